"""[Long2013] repeated: trials, rows that set its figures beside ours, figures."""
