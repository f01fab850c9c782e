"""Whether a richer model is worth its parameters: which of them predicts the legs that it has not seen better."""
