"""A first look at a recording: what it holds, what it is fit for, and what is odd about it."""
