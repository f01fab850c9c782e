"""Models of increasing size, compared by legs of a recording that are held out in turn."""
