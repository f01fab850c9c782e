"""Results as sentences and table rows, shared by pages, viewer recordings and terminal."""
