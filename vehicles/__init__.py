"""A vehicle: estimator, predictor, controllers, the agent and its process."""
