"""What page, viewer, terminal and notebook show of a diagnosis: words, rows and series, computed once."""
