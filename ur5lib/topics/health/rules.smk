PRIORITY["track_health"] = 1  # it takes long for thousands of recordings
