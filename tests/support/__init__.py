"""Scenes and statistics that several tests share; these do import `cpm`."""
