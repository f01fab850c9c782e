"""From evidence to effects accepted and one verdict."""
