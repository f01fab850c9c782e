"""What people look at: words, pictures, recordings for the rerun viewer, pages."""
