"""Whether the server in this container is ready: exit status 0 or 1."""

import os
import sys
import urllib.request

url = f"http://127.0.0.1:{os.environ.get('GAINSCOPE_PORT', '8050')}/readyz"
try:
    # Without the proxies that the environment may name: they do not know this container.
    urllib.request.build_opener(urllib.request.ProxyHandler({})).open(url, timeout=4)
except OSError as error:
    sys.exit(f"{url}: {error}")
