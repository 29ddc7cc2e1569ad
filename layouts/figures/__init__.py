"""Results as figures: plain plotly dictionaries. Nothing here knows Dash.

Every module has one function that makes a figure from a result, and MOVING: the parts of that figure that change
with the gains, so that a page can send just those.
"""
