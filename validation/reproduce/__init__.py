"""Reproductions: each paper's figures beside ours, one file a paper."""
