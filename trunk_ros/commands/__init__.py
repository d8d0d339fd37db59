"""The commands: arguments in, a call, words out. What they call is imported when they run: help is quick."""
