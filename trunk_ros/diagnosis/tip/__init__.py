"""The arm stage: joint angles to the tip."""
