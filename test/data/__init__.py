"""What clocks and sensors did to recordings."""
