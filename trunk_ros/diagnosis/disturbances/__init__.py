"""What a joint does that no effect of its wire says: where it rests at first, how it is thrown or
knocked, how it swings from before, and how far its drive overshoots a stop.
"""
