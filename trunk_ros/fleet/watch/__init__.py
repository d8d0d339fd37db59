"""One arm under watch: residuals against its model as they come, tested in sequence at a stated rate of
false alarms.
"""
