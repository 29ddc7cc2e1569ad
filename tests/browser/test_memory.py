"""What a browser keeps of pages that are gone."""

import pytest

from trials import heap

pytestmark = pytest.mark.browser


def test_a_page_that_is_left_is_let_go(open_page, port):
    before, after = heap.walk(open_page(), f"http://127.0.0.1:{port}/", heap.SHORT)
    assert after.megabytes - before.megabytes < heap.GROWTH
    # Seven pages that are kept have thousands; the browser itself holds one at times, the first time or the second.
    assert after.nodes - before.nodes < 1_500
