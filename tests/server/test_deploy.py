"""What is built and started around the server: image, containers, proxy, dashboard, and the page that tells of them."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from ipaddress import ip_address, ip_network
from pathlib import Path
from types import MappingProxyType

import pytest
import yaml
from fastapi import FastAPI

import app
from layouts.files import Store
from scripts import audit, licences, trim
from scripts import settings as page_of_settings
from server import metrics
from server.descriptors import needed
from server.guard import HEALTH
from server.lifecycle import LONGEST, config_of
from server.settings import MOST_HELPERS, Settings

ROOT = Path(__file__).parents[2]
DEPLOY = ROOT / "deploy"
COMPOSE = ("compose.yaml", "compose.replicas.yaml")
OWN_IMAGE = "${IMAGE:-gainscope}"

# The one that is root: its image's volumes belong to root, and of root's rights it has one.
ROOT_WITHOUT_RIGHTS = {"proxy": ["NET_BIND_SERVICE"]}


# Containers -----------------------------------------------------------------------------------------------------------


def merged(below, above):
    """What `extends` makes of two services: mappings are joined, lists as well, the rest is replaced."""
    result = dict(below)
    for key, value in above.items():
        had = result.get(key)
        if isinstance(had, dict) and isinstance(value, dict):
            result[key] = merged(had, value)
        elif isinstance(had, list) and isinstance(value, list) and key not in ("command", "entrypoint"):
            result[key] = had + value
        else:
            result[key] = value
    return result


def service(file, name):
    told = yaml.safe_load(file.read_text())["services"][name]
    if "extends" not in told:
        return told
    extends = told["extends"]
    below = service(file.parent / extends["file"] if "file" in extends else file, extends["service"])
    return merged(below, {key: value for key, value in told.items() if key != "extends"})


def services(name):
    """All services of a compose file and of what it includes."""
    files = [ROOT / name]
    files += [ROOT / included for included in yaml.safe_load(files[0].read_text()).get("include", ())]
    return {each: service(file, each) for file in files for each in yaml.safe_load(file.read_text())["services"]}


TOLD = [(each, told, f"{name}:{each}") for name in COMPOSE for each, told in services(name).items()]
NAMED = [pytest.param(each, told, id=name) for each, told, name in TOLD]
EVERY = [pytest.param(told, id=name) for _, told, name in TOLD]
SERVERS = [pytest.param(told, id=name) for each, told, name in TOLD if each.startswith("gainscope")]


@pytest.mark.parametrize(("name", "told"), NAMED)
def test_every_container_is_held(name, told):
    assert told["read_only"] is True
    assert told["cap_drop"] == ["ALL"]
    assert told.get("cap_add", []) == ROOT_WITHOUT_RIGHTS.get(name, [])
    assert told["security_opt"] == ["no-new-privileges:true"]
    assert not {"privileged", "network_mode", "pid", "devices"} & told.keys()
    assert told["mem_limit"]
    assert told["pids_limit"]


@pytest.mark.parametrize(("name", "told"), NAMED)
def test_no_container_is_root_but_the_proxy(name, told):
    user = told.get("user", "10001:10001" if told["image"] == OWN_IMAGE else "0:0")
    assert (user.partition(":")[0] == "0") == (name in ROOT_WITHOUT_RIGHTS)


@pytest.mark.parametrize("told", EVERY)
def test_images_of_others_have_a_version(told):
    assert told["image"] == OWN_IMAGE or re.fullmatch(r"[a-z/]+:v?\d+\.\d+\.\d+(-alpine)?", told["image"])


@pytest.mark.parametrize("told", EVERY)
def test_every_container_says_whether_it_is_well(told):
    assert "test" in told["healthcheck"] or told["healthcheck"] == {"disable": True}


@pytest.mark.parametrize("name", COMPOSE)
def test_nobody_elsewhere_reaches_more_than_the_proxy(name):
    open_to_all = {
        each for each, told in services(name).items() for port in told.get("ports", ()) if "127.0.0.1:" not in port
    }
    assert open_to_all == ({"proxy"} if "replicas" in name else set())


@pytest.mark.parametrize("name", COMPOSE)
def test_what_is_mounted_from_here_is_there_and_cannot_be_changed(name):
    for each, told in services(name).items():
        for volume in told.get("volumes", ()):
            source, _, mode = volume.split(":") if volume.count(":") == 2 else (*volume.split(":"), "")
            if source.startswith("."):
                base = ROOT if each == "proxy" else DEPLOY
                assert (base / source).exists()
                assert mode == "ro"


def test_three_servers_are_alike_and_trust_the_proxy_alone():
    told = services("compose.replicas.yaml")
    ours = [told[f"gainscope-{number}"] for number in (1, 2, 3)]
    assert ours[0] == ours[1] == ours[2]
    addresses = told["proxy"]["networks"]["default"].values()
    assert set(ours[0]["environment"]["GAINSCOPE_PROXIES"].split(",")) == set(addresses)
    assert "recordings:/data" in ours[0]["volumes"]


def test_the_proxy_has_an_address_of_its_own_for_visitors_of_either_protocol():
    """Docker's own proxy would pass on those over IPv6, and all would come from one address."""
    networks = yaml.safe_load((ROOT / "compose.replicas.yaml").read_text())["networks"]
    assert networks["default"]["enable_ipv6"] is True
    four, six = networks["default"]["ipam"]["config"]
    addresses = services("compose.replicas.yaml")["proxy"]["networks"]["default"]
    for version, config in ((4, four), (6, six)):
        subnet, address = ip_network(config["subnet"]), ip_address(addresses[f"ipv{version}_address"])
        assert (subnet.version, subnet.is_private) == (version, True)
        assert address in subnet
    # Nobody else is given it: others get one of a range without it, or one of the lowest.
    assert ip_address(addresses["ipv4_address"]) not in ip_network(four["ip_range"])
    assert int(ip_address(addresses["ipv6_address"])) - int(ip_network(six["subnet"])[0]) > 1000


def filled(text, environment=MappingProxyType({})):
    """A value of a compose file, as it is where these variables are set."""

    def fill(found):
        name, if_empty_as_well, usual = found.groups()
        value = environment.get(name)
        return usual if value is None or (if_empty_as_well and not value) else value

    return re.sub(r"\$\{(\w+)(:?)-([^}]*)\}", fill, text)


@pytest.mark.parametrize("told", EVERY)
def test_every_setting_that_a_container_is_given_exists(told):
    given = {name: value for name, value in told.get("environment", {}).items() if name.startswith("GAINSCOPE_")}
    usual = {name: filled(value) for name, value in given.items()}
    assert given.keys() <= Settings.from_environment(usual).shown().keys()


@pytest.mark.parametrize("told", SERVERS)
def test_a_server_is_where_others_look_for_it_whatever_else_is_set(told):
    """What is in the file of settings counts less than what stands in a compose file."""
    given = told["environment"]
    assert given["GAINSCOPE_HOST"] == "0.0.0.0"
    port = given["GAINSCOPE_PORT"]
    looked_for = [published.rpartition(":")[2] for published in told.get("ports", ())]
    looked_for += re.findall(r"gainscope-\d:(\d+)", (DEPLOY / "Caddyfile").read_text())
    looked_for += re.findall(r"port: (\d+)", (DEPLOY / "prometheus.yaml").read_text())
    assert len(looked_for) >= 4
    assert set(looked_for) == {port}


@pytest.mark.parametrize("told", SERVERS)
def test_recordings_are_kept_in_the_volume_or_nowhere(told):
    folder = told["environment"]["GAINSCOPE_DATA"]
    assert f"recordings:{filled(folder)}" in told["volumes"]
    assert filled(folder, {"GAINSCOPE_DATA": ""}) == ""


@pytest.mark.parametrize("name", COMPOSE)
def test_what_another_container_is_told_the_servers_are_told_as_well(name):
    told = services(name)
    for each in told.values():
        for variable, value in each.get("environment", {}).items():
            if variable.startswith("GAINSCOPE_") and value.startswith("${"):
                ours = [server["environment"][variable] for key, server in told.items() if key.startswith("gainscope")]
                assert {filled(one, {variable: "set"}) for one in ours} == {"set"}


@pytest.mark.parametrize("told", SERVERS)
def test_a_server_may_open_as_much_as_its_settings_need(told):
    assert told["ulimits"]["nofile"]["hard"] > 10 * needed(Settings(helpers=MOST_HELPERS))


def test_a_server_has_longer_to_stop_than_it_takes():
    grace = services("compose.yaml")["gainscope"]["stop_grace_period"]
    assert float(grace.removesuffix("s")) > LONGEST + 1


# Image ----------------------------------------------------------------------------------------------------------------


def instructions():
    text = re.sub(r"^\s*#.*\n", "", (ROOT / "Dockerfile").read_text(), flags=re.MULTILINE)
    joined = re.sub(r"\\\n", " ", text)
    return [tuple(line.split(maxsplit=1)) for line in joined.splitlines() if line.strip()]


def test_the_image_takes_nothing_but_this_checkout_and_the_lock():
    told = instructions()
    assert not [each for each in told if each[0] == "ADD"]
    [install] = [line for word, line in told if word == "RUN" and "pip" in line and "install" in line]
    assert "--require-hashes" in install
    assert "--only-binary :all:" in install
    assert not [line for word, line in told if word == "RUN" and re.search(r"apt|curl|wget|git ", line)]


def test_the_last_stage_is_nobody_and_says_whether_it_is_well():
    told = instructions()
    last = max(place for place, (word, _) in enumerate(told) if word == "FROM")
    final = [(word, line) for word, line in told[last:]]
    assert ("USER", "10001:10001") in final
    assert [word for word, _ in final].count("HEALTHCHECK") == 1
    assert "pip" not in "".join(line for word, line in final if word in ("CMD", "ENTRYPOINT"))
    assert [line for word, line in final if word == "VOLUME"] == ["/data"]
    # Whatever is copied comes from the stage before.
    assert all(line.startswith("--from=build") for word, line in final if word == "COPY")


def test_what_is_trimmed_is_there_and_the_rest_stays(tmp_path):
    for pattern in trim.UNUSED:
        path = tmp_path / pattern.replace("**", "package/deep").replace("*", "x").replace("[0-9]", "1").rstrip("/")
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.suffix in (".js", ".map", ".pth"):
            path.write_bytes(b"12345")
        else:
            path.mkdir(exist_ok=True)
            (path / "module.py").write_bytes(b"12345")
    kept = tmp_path / "plotly" / "graph_objs" / "_figure.py"
    kept.write_bytes(b"")
    removed = trim.trim(tmp_path)
    assert set(removed) == set(trim.UNUSED)
    assert all(removed.values())
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == [kept]


def test_a_line_of_the_trimming_that_finds_nothing_ends_the_build(tmp_path):
    with pytest.raises(FileNotFoundError, match=re.escape(next(iter(trim.UNUSED)))):
        trim.trim(tmp_path)


# Proxy and dashboard --------------------------------------------------------------------------------------------------


@pytest.mark.skipif(shutil.which("caddy") is None, reason="there is no caddy on the path")
def test_the_proxy_understands_what_it_is_told():
    config = ["--config", str(DEPLOY / "Caddyfile"), "--adapter", "caddyfile"]
    done = subprocess.run(["caddy", "adapt", *config], capture_output=True, text=True, check=True)
    told = json.loads(done.stdout)
    found = re.findall(r'"policy": ?"(\w+)"', json.dumps(told))
    assert found == ["cookie"]
    assert re.findall(r'"dial": ?"([^"]+)"', json.dumps(told)) == [f"gainscope-{n}:8050" for n in (1, 2, 3)]
    assert '"X-Request-Id": ["{http.request.uuid}"]' in json.dumps(told)


def test_the_proxy_takes_the_largest_recording_and_little_more():
    [size] = re.findall(r"max_size (\d+)MB", (DEPLOY / "Caddyfile").read_text())
    assert Settings().upload_mb < int(size) < 2 * Settings().upload_mb


def test_the_proxy_does_not_keep_a_connection_as_long_as_the_servers():
    [seconds] = re.findall(r"transport http \{\s+keepalive (\d+)s\s+\}", (DEPLOY / "Caddyfile").read_text())
    assert int(seconds) < config_of(Settings(), FastAPI()).timeout_keep_alive - 5


def test_a_visitor_does_not_give_requests_their_numbers():
    assert "header_up X-Request-Id {http.request.uuid}" in (DEPLOY / "Caddyfile").read_text()
    assert "proxy_set_header X-Request-Id $request_id;" in (ROOT / "docs" / "server.md").read_text()


def panels():
    return json.loads((DEPLOY / "grafana" / "gainscope.json").read_text())["panels"]


def rules():
    return yaml.safe_load((DEPLOY / "alerts.yaml").read_text())["groups"][0]["rules"]


def expressions():
    shown = [target["expr"] for panel in panels() for target in panel.get("targets", ())]
    return shown + [rule["expr"] for rule in rules()]


class Asked:
    """What an expression asks for: labels that it sums by, and of each figure its name and what its labels must be."""

    def __init__(self, expr):
        self.by = {label.strip() for labels in re.findall(r"\bby \(([^)]*)\)", expr) for label in labels.split(",")}
        found = re.findall(r"\b((?:gainscope|process)_\w+)(?:\{([^}]*)\})?", expr)
        self.figures = [(name, re.findall(r'(\w+)(=~|!~|!=|=)"([^"]*)"', told)) for name, told in found]


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    store = Store(tmp_path_factory.mktemp("recordings"), most_bytes=1, longest_age_days=1)
    return app.build(store=store).server


@pytest.fixture(scope="module")
def known(server):
    """All figures of the server as Prometheus has them, by name: what each of their labels has been until now."""
    figures = {}
    for family in metrics.REGISTRY.collect():
        ending = {"counter": ["_total"], "histogram": ["_bucket", "_sum", "_count"]}.get(family.type, [])
        for name in (family.name, *(family.name + end for end in ending)):
            # A figure that was never counted has no sample that would show its labels.
            collector = metrics.REGISTRY._names_to_collectors.get(name)
            labels = {label: set() for label in getattr(collector, "_labelnames", ())}
            figures[name] = labels | ({"le": set()} if name.endswith("_bucket") else {})
        for sample in family.samples:
            for label, value in sample.labels.items():
                figures[sample.name].setdefault(label, set()).add(value)
    return figures


def test_every_figure_of_the_dashboard_and_the_alarms_is_one_of_the_server(known):
    asked = {name for expr in expressions() for name, _ in Asked(expr).figures}
    assert len(asked) > 10
    assert asked <= known.keys()


OF_PROMETHEUS = {"job", "instance"}


def test_every_label_that_is_asked_for_is_one_of_its_figure(known, server):
    [job] = yaml.safe_load((DEPLOY / "prometheus.yaml").read_text())["scrape_configs"]
    routes = {route.path for route in server.routes}
    seen = set()
    for expr in expressions():
        asked = Asked(expr)
        for name, told in asked.figures:
            assert asked.by <= known[name].keys() | OF_PROMETHEUS
            for label, comparison, value in told:
                assert label in known[name].keys() | OF_PROMETHEUS
                if "$" in value:
                    continue
                seen.add(label)
                values = {"job": {job["job_name"]}, "route": routes}.get(label) or known[name][label]
                if "~" not in comparison:
                    assert value in values
                    continue
                # Every word of it is there for something.
                found = {each for each in values if re.fullmatch(value, each)}
                assert [word for word in re.findall(r"\w+", value) if word not in " ".join(found)] == []
    assert seen == {"job", "route", "work"}


def test_what_is_written_beside_a_line_is_something_that_it_is_told_apart_by():
    written = [
        (target["expr"], re.findall(r"\{\{(\w+)\}\}", target["legendFormat"]))
        for panel in panels()
        for target in panel.get("targets", ())
    ]
    written += [(rule["expr"], re.findall(r"\$labels\.(\w+)", rule["annotations"]["summary"])) for rule in rules()]
    assert sum(len(labels) for _, labels in written) > 20
    for expr, labels in written:
        is_summed = re.search(r"\b(sum|min|max|quantile)\b", expr.replace("histogram_quantile", ""))
        assert set(labels) <= (Asked(expr).by if is_summed else OF_PROMETHEUS)


def test_what_machines_ask_for_is_in_no_figure_of_answers():
    """It is quick and comes all the time: among it nothing of a slow answer could be seen."""
    asked = [
        told for expr in expressions() for name, told in Asked(expr).figures if name.startswith("gainscope_request")
    ]
    assert len(asked) >= 6
    for told in asked:
        left_out = [value for label, comparison, value in told if (label, comparison) == ("route", "!~")]
        assert all(any(re.fullmatch(value, path) for value in left_out) for path in (*HEALTH, metrics.PATH))


@pytest.mark.parametrize("name", ["resident_memory_bytes", "cpu_seconds_total"])
def test_what_the_server_takes_is_never_shown_without_what_it_has_started(name):
    together = [" ".join(target["expr"] for target in panel.get("targets", ())) for panel in panels()]
    together += [rule["expr"] for rule in rules()]
    shown = [expr for expr in together if f"process_{name}" in expr or f"gainscope_children_{name}" in expr]
    assert shown
    for expr in shown:
        assert f"process_{name}" in expr
        assert f"gainscope_children_{name}" in expr


def test_the_alarm_for_memory_comes_before_the_end_of_it():
    [expr] = [rule["expr"] for rule in rules() if rule["alert"] == "Memory"]
    limit = services("compose.yaml")["gainscope"]["mem_limit"]
    assert float(expr.rpartition("> ")[2]) < 0.9 * int(limit.removesuffix("g")) * 2**30


def test_every_kind_of_figure_is_on_the_dashboard(known):
    ours = {re.sub(r"_(total|bucket|sum|count)$", "", name) for name in known if name.startswith("gainscope_")}
    shown = " ".join(expressions())
    assert [name for name in sorted(ours) if name not in shown] == []


def test_panels_do_not_overlap():
    taken = set()
    for panel in panels():
        place = panel["gridPos"]
        cells = {(place["x"] + x, place["y"] + y) for x in range(place["w"]) for y in range(place["h"])}
        assert not taken & cells
        assert max(x for x, _ in cells) < 24
        taken |= cells
    assert len({panel["id"] for panel in panels()}) == len(panels())


# Pages ----------------------------------------------------------------------------------------------------------------


def test_the_table_of_settings_is_what_the_server_reads():
    assert page_of_settings.page() == page_of_settings.TARGET.read_text(encoding="utf-8")


def test_the_page_names_no_file_or_place_that_is_not_there():
    page = (ROOT / "docs" / "server.md").read_text()
    titles = re.findall(r"^## (.*)", page, re.MULTILINE)
    headings = {re.sub(r"[^a-z0-9 -]", "", title.lower()).replace(" ", "-") for title in titles}
    for link in re.findall(r"\]\((?!https)([^)]+)\)", page):
        file, _, part = link.partition("#")
        assert not file or (ROOT / "docs" / file).resolve().exists()
        assert file or part in headings
    for name in re.findall(r"`((?:deploy|scripts)/[\w./]+)`", page):
        assert (ROOT / name).exists()


def test_the_licences_are_those_of_the_lock():
    rows = re.findall(r"^\| ([a-z0-9-]+) \| ([\d., a-z]+) \| (.+) \|$", licences.PAGE.read_text(), re.MULTILINE)
    assert {name: version for name, version, _ in rows if name != "package"} == licences.locked()


# Audit ----------------------------------------------------------------------------------------------------------------

CLEAN = {"name": "numpy", "version": "2.4.6", "vulns": []}
KNOWN = {"name": "pillow", "version": "1.0.0", "vulns": [{"id": "PYSEC-0", "fix_versions": ["1.0.1"]}]}
SKIPPED = {"name": "dash", "skip_reason": "Dependency not found"}


@pytest.mark.parametrize(
    ("packages", "status", "said"),
    [
        ([CLEAN], audit.CLEAN, "1 packages, nothing is known against them"),
        ([CLEAN, KNOWN], audit.KNOWN, "pillow 1.0.0: PYSEC-0, mended in 1.0.1"),
        ([CLEAN, SKIPPED], audit.UNASKED, "THE AUDIT WAS NOT MADE of 1 of 2 packages"),
        ([KNOWN, SKIPPED], audit.KNOWN, "THE AUDIT WAS NOT MADE of 1 of 2 packages"),
        ([], audit.UNASKED, "THE AUDIT WAS NOT MADE of 0 of 0 packages"),
    ],
)
def test_an_audit_that_was_none_does_not_pass_for_one(packages, status, said):
    found, lines = audit.verdict(json.dumps({"dependencies": packages}))
    assert found == status
    assert any(line.startswith(said) for line in lines)


@pytest.mark.parametrize("report", ["", "null", "{}", "Traceback"])
def test_an_audit_without_a_report_was_not_made(report):
    status, [line] = audit.verdict(report, "first\nConnectionError: no way there\n")
    assert status == audit.UNASKED
    assert line == "THE AUDIT WAS NOT MADE: ConnectionError: no way there"
