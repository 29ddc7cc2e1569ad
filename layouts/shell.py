"""What stands around every page: head of the document, header, navigation, theme switch."""

from __future__ import annotations

from dash import dcc, html, page_container, page_registry
from dash.development.base_component import Component

from server.work import SECONDS

INDEX = """<!DOCTYPE html>
<html lang="en">
<head>
{%metas%}
<title>{%title%}</title>
<link rel="icon" type="image/svg+xml" href="/assets/favicon.svg">
<script src="/assets/theme.js"></script>
{%css%}
<link rel="preload" as="script" href="/_dash-component-suites/dash/dcc/async-graph.js">
<link rel="preload" as="script" href="/_dash-component-suites/plotly/package_data/plotly.min.js" fetchpriority="low">
</head>
<body>
<a class="skip" href="#main">Skip to the page</a>
{%app_entry%}
<noscript>Gainscope draws in the browser and needs JavaScript.</noscript>
{%config%}
{%scripts%}
{%renderer%}
</body>
</html>"""

THEME_SCRIPT = "theme.js"
"""Stands in the head, so that the first paint has the right colours; the other scripts come after the page."""


WITHOUT_FILTER = ("Papers", "Learn")
"""Pages that show no filter of the user's."""


def _link(name: str, path: str) -> Component:
    """A page in the navigation; assets/desk.js lets the addresses of those with a filter carry the present one."""
    carries = "" if name in WITHOUT_FILTER else " carries"
    return dcc.Link(name, href=path, id=f"to-{name.lower()}", className=f"page-link{carries}")


def frame(answer_seconds: float = SECONDS) -> Component:
    """The page of the application, with a place for the present page in it.

    Args:
        answer_seconds: that the server may take for an answer; pages wait for it a little longer.
    """
    links = [html.Li(_link(page["name"], page["relative_path"])) for page in page_registry.values()]
    return html.Div(
        [
            html.Header(
                [
                    html.Div(
                        [
                            html.Img(src="assets/favicon.svg", alt="", width=26, height=26),
                            html.Span("Gainscope", className="brand"),
                            html.Span("fixed-gain tracking filters", className="claim"),
                        ],
                        className="brand-block",
                    ),
                    html.Nav(html.Ul(links), **{"aria-label": "Pages"}) if len(links) > 1 else None,
                    html.Div(
                        [
                            html.Button(
                                "↶",
                                id="undo",
                                type="button",
                                className="quiet",
                                disabled=True,
                                title="Undo (Ctrl+Z)",
                                **{"aria-label": "Undo"},
                            ),
                            html.Button(
                                "↷",
                                id="redo",
                                type="button",
                                className="quiet",
                                disabled=True,
                                title="Redo (Ctrl+Y)",
                                **{"aria-label": "Redo"},
                            ),
                            html.Button("Copy link", id="copy-link", type="button", className="quiet"),
                            html.Span(id="copy-said", role="status", className="visually-hidden"),
                            html.Button(
                                id="theme-switch",
                                type="button",
                                className="quiet",
                                **{"aria-label": "Switch between light and dark"},
                            ),
                        ],
                        className="header-tools",
                    ),
                ],
                className="header",
            ),
            html.Div(id="missing-recording", className="banner", role="alert", hidden=True),
            html.Main(page_container, id="main"),
        ],
        className="app",
        **{"data-answer-seconds": f"{answer_seconds:g}"},
    )
