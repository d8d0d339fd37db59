"""What many recordings say together: the arm's own values, trends, changes, and what all arms share."""
