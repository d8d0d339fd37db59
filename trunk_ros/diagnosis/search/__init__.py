"""The search for the hypothesis that explains a stage best for its price."""
