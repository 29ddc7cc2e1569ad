"""What stands between the network and the pages: settings, limits, headers, errors, figures of its own work.

It knows no page. Every request and every socket passes through it.
"""
