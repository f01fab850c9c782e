"""Where a recording and a model disagree, what is missing, and the model with it."""
