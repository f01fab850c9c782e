"""Cross-validation of models: whether a richer model predicts held-out legs better."""
