"""Content security policies: what they allow, and that they name the scripts of a document and no other."""

import base64
import hashlib

import pytest

from server.policy import inline_scripts, policy, source


def directives(text):
    """The sources by directive."""
    return {part.split()[0]: part.split()[1:] for part in text.split("; ")}


def test_without_more_everything_is_of_this_server():
    assert directives(policy()) == {
        "default-src": ["'self'"],
        "script-src": ["'self'"],
        "object-src": ["'none'"],
        "base-uri": ["'none'"],
        "form-action": ["'none'"],
    }


def test_a_script_is_named_by_its_hash():
    # From the standard's own example of a hash of nothing.
    assert source("") == "'sha256-47DEQpj8HBSa+/TImW+5JCeuQeRkm5NMpJWZG3hSuFU='"
    assert directives(policy("alert(1)", "α"))["script-src"] == ["'self'", source("alert(1)"), source("α")]
    digest = hashlib.sha256("α".encode()).digest()
    assert source("α") == f"'sha256-{base64.b64encode(digest).decode()}'"


def test_other_sources_stand_in_place_of_this_server():
    given = directives(policy("x", default_src="'none'", script_src="'wasm-unsafe-eval'", img_src="data: blob:"))
    assert given["default-src"] == ["'none'"]
    assert given["script-src"] == ["'wasm-unsafe-eval'", source("x")]
    assert given["img-src"] == ["data:", "blob:"]


DOCUMENTS = {
    "<script>one</script>": ["one"],
    "<script>\n two \n</script><script>three</script>": ["\n two \n", "three"],
    '<script id="a" type="application/javascript">four</script>': ["four"],
    "<script type=module>five</script>": ["five"],
    '<script src="x.js"></script>': [],
    '<script async src="x.js"></script>': [],
    '<script type="application/json">{"a": 1}</script>': [],
    '<script data-src="x">six</script>': ["six"],
    '<script data-p="a type=application/json src=x">seven</script>': ["seven"],
    "<SCRIPT>a < b && '<p>' && c</SCRIPT>": ["a < b && '<p>' && c"],
    "<p>script</p>": [],
}


@pytest.mark.parametrize("document", DOCUMENTS)
def test_the_scripts_that_stand_in_a_document_are_found(document):
    assert inline_scripts(document) == DOCUMENTS[document]
