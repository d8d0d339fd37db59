"""A recording to look at in Rerun: the arm in 3D, joints, residuals and findings on one time line."""
