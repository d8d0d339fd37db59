"""What every node shares with the ROS graph: streams, clock, parameters, diagnostics."""
