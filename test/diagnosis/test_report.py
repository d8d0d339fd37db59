"""The page: what it says, that it is one safe file, and that its curves show what was found."""

import base64
import hashlib
import json
import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from test.diagnosis import made
from test.diagnosis.made import page_of
from trunk_ros.commands.diagnose import spoken
from trunk_ros.diagnosis.report import render, write
from trunk_ros.diagnosis.report.regimes import stretches
from trunk_ros.diagnosis.report.series import thinned
from trunk_ros.diagnosis.report.signals import signals
from trunk_ros.diagnosis.report.where import maps
from trunk_ros.diagnosis.verdict.answer import Unexplained
from trunk_ros.diagnosis.verdict.result import Diagnosis
from trunk_ros.recording.topics import TOPICS

PARTS = [
    "What to do next", "Where", "Before and after", "Over time", "What was found", "Still unexplained",
    "Decisive motion", "Quality of the data", "To reproduce",
]  # fmt: skip


class Page(HTMLParser):
    """Tags with their attributes, and the text of each kind of tag."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.text: dict[str, list[str]] = {}
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))

    def handle_data(self, data: str) -> None:
        self.text.setdefault(self.tags[-1][0] if self.tags else "", []).append(data)


def pictures(page: str) -> list[str]:
    """The SVG of all images of a page."""
    return [
        base64.b64decode(x).decode()
        for x in re.findall(r"data:image/svg\+xml;base64,([A-Za-z0-9+/=]+)", page)
    ]


def words(page: str) -> str:
    """What a reader sees, in one line."""
    text = re.sub(r"<(style|script)\b.*?</\1>", "", page, flags=re.S)
    return " ".join(re.sub(r"<[^>]+>", " ", text).replace("\N{NO-BREAK SPACE}", " ").split())


@pytest.fixture(scope="module")
def found() -> Diagnosis:
    return made.backlash()


@pytest.fixture(scope="module")
def page(found: Diagnosis) -> str:
    return render(found)


def test_the_first_heading_is_the_verdict_in_one_sentence(page: str) -> None:
    tags = [tag for tag, _ in Page(page).tags]
    assert next(tag for tag in tags if re.fullmatch(r"h\d", tag)) == "h1"
    assert re.search(r"<h1>Missing in the simulation: backlash \(joint_3, \d+%\)\.</h1>", page)
    fall = r"wire joint_3: 0\.9\d+ → 0\.1\d* mrad \(10\.0 → 1\.0 times the noise\)\."
    assert re.search(f"Held-out error of the worst signal, {fall}", words(page))


def test_more_than_two_effects_are_counted_in_the_heading_and_listed_below(found: Diagnosis) -> None:
    others = [replace(found.findings[0], effect=name) for name in ("backlash", "ratio_error", "cogging")]
    page = page_of(replace(found, findings=others))
    assert "<h1>3 effects are missing in the simulation.</h1>" in page
    assert all(f"<b>{name}</b>" in page for name in ("backlash", "ratio error", "cogging"))


@pytest.mark.parametrize("sure", [0.04, 0.5])
def test_the_heading_tells_what_could_be_another_and_what_is_a_guess(found: Diagnosis, sure: float) -> None:
    """A half is what a finding is capped at whose size is no larger than its error: 0.8 ± 4 mrad."""
    others = [replace(found.findings[0], effect=name) for name in ("backlash", "ratio_error", "cogging")]
    doubts = [replace(others[0], confidence=sure), replace(others[1], equivalents=["cogging"]), others[2]]
    page = page_of(replace(found, findings=doubts))
    assert (
        "simulation; 1 of them could also be another effect and 1 of them is no more than a guess.</h1>"
        in page
    )
    page = page_of(replace(found, findings=doubts[:2]))
    assert re.search(
        rf"simulation: ratio error or cogging \(.*\) and perhaps backlash \(joint_3, {sure:.0%}\)", page
    )


def test_nothing_missing_is_said_only_of_what_was_judged() -> None:
    clean = made.diagnosis({}, [])
    assert "No effect is missing: what remains (99." in words(page_of(clean))
    assert "rms at most) is no more than the sensors' noise." in words(page_of(clean)).replace("&#39;", "'")
    clean.stages["wire"] = {"compared": True, "joints": {}, "silent": list(made.JOINTS)}
    clean.plots = {}
    text = words(page_of(clean))
    assert "No effect is missing" not in text
    assert "Nothing can be said" in text
    assert "nothing judged" in text


def test_a_joint_that_hardly_moves_is_said_to_be_unknown(found: Diagnosis) -> None:
    stages = {**found.stages, "wire": {**found.stages["wire"], "silent": ["joint_6"]}}
    assert "joint_6 hardly moves" in words(page_of(replace(found, stages=stages)))


def test_the_page_needs_no_other_file(page: str) -> None:
    ids = {attributes.get("id") for _, attributes in Page(page).tags}
    for tag, attributes in Page(page).tags:
        assert tag not in ("link", "iframe", "object", "embed")
        assert all(not name.startswith("on") and name != "style" for name in attributes)
        href = attributes.get("href")
        assert href is None or (href[0] == "#" and href[1:] in ids)
        assert (attributes.get("src") or "data:").startswith("data:")
    assert "default-src 'none'" in page
    assert "url(" not in page


def test_only_the_page_s_own_script_and_style_may_run(found: Diagnosis, page: str) -> None:
    policy = re.findall(r'Content-Security-Policy" content="([^"]*)"', page)[0]
    assert "unsafe" not in policy
    for tag, rule in (("style", "style-src"), ("script", "script-src")):
        texts = re.findall(f"<{tag}>(.*?)</{tag}>", page, re.S)
        digests = [base64.b64encode(hashlib.sha256(text.encode()).digest()).decode() for text in texts]
        assert re.findall(f"{rule} 'sha256-([^']*)'", policy) == digests
    quiet = page_of(replace(found, plots={}))
    assert "script" not in Page(quiet).text
    assert "script-src" not in quiet


def test_the_plots_hold_what_was_measured_and_both_residuals(found: Diagnosis, page: str) -> None:
    held = json.loads(re.findall(r'<script type="application/json" id="series">(.*?)</script>', page)[0])
    shown = next(s for s in held["signals"] if s["name"] == "wire · joint_3")
    t, measured, before, after = (
        np.frombuffer(base64.b64decode(text), "<f4")
        for text in (shown["time"], shown["measured"], *shown["residuals"])
    )
    signal = next(s for s in signals(found) if s.name == "joint_3")
    rows = np.searchsorted(signal.stamp, t - 1e-3)
    assert (shown["unit"], shown["residual_unit"]) == ("°", "mrad")
    assert np.radians(measured) == pytest.approx(signal.measured[rows], abs=1e-6)
    assert np.nanmax(np.abs(before)) == pytest.approx(1e3 * np.nanmax(np.abs(signal.error_before)), rel=1e-5)
    assert np.nanmax(np.abs(after)) == pytest.approx(1e3 * np.nanmax(np.abs(signal.error_after)), rel=1e-5)
    predicted = np.radians(measured - shown["scale"] * before)
    assert predicted[t > 3] == pytest.approx(signal.before[rows][t > 3], abs=1e-6)
    assert len(t) < 3000


def test_a_spike_of_one_sample_is_not_thinned_away(found: Diagnosis) -> None:
    spiked = made.backlash()
    for key in ("measured", "error_before", "error_after"):
        spiked.plots["wire", "joint_3"][key][3217] += 0.02
    signal = next(s for s in signals(spiked) if s.name == "joint_3")
    assert 3217 in thinned(signal)


def test_reversals_are_shaded_where_the_joint_turns() -> None:
    t = np.arange(0.0, 40.0, 0.01)
    spans = stretches(t, np.sin(2 * np.pi * t / 20.0), "reversal")
    assert [start for start, _ in spans] == [pytest.approx(at, abs=0.6) for at in (5.0, 15.0, 25.0, 35.0)]
    assert all(end - start < 2.0 for start, end in spans)
    assert stretches(t, np.sin(t), "posture") == []


def test_correlated_values_and_those_at_a_bound_are_said(found: Diagnosis) -> None:
    place = {"effect": "backlash", "parameter": "half_width", "joint": "joint_3"}
    other = {"effect": "stribeck_friction", "parameter": "amplitude", "joint": "joint_3"}
    told = {
        "correlations": [{"first": place, "second": other, "value": -0.97}],
        "at_bound": [{"place": place, "side": "upper", "bound": 1.0, "unit": "rad"}],
    }
    (finding,) = found.findings
    finding = replace(finding, evidence={**finding.evidence, **told})
    text = words(page_of(replace(found, findings=[finding])))
    assert "half width (joint_3) and stribeck friction amplitude (joint_3): −0.97" in text
    assert "half width (joint_3), upper bound 57.3 °" in text


def test_what_to_do_next_follows_from_what_was_found(found: Diagnosis) -> None:
    text = words(page_of(found))
    assert "Compensate with this model" in text
    assert text.index("Compensate with") < text.index("Put what was found into your simulator.")
    assert "trunk_ros export model.yaml --to mjcf --into arm.xml" in text
    assert "Record trunk/setpoints and trunk/gearbox_states too." in text
    told = {"separates": ["backlash", "tension_error"], "statement": "x", "trajectory": "a.yaml"}
    text = words(page_of(replace(found, experiments=[told])))
    assert "Record this motion: a.yaml. It tells backlash from tension error" in text
    late = replace(found.findings[0], effect="sensor_delay")
    assert "Compensate" not in words(page_of(replace(found, findings=[late])))
    quiet = made.diagnosis({}, [])
    quiet.quality["run1"]["topics"] = dict.fromkeys(TOPICS, quiet.quality["run1"]["topics"]["joint_states"])
    assert "Nothing to change." in words(page_of(quiet))


@pytest.mark.parametrize(
    "name",
    [
        "<script>alert(1)</script>",
        "</style><img src=x onerror=alert(1)>",
        '"><u>',
        "$x^{",
        "a\x00\x1b",
        "{{ 7*7 }}",
    ],
)
def test_names_from_a_recording_are_never_markup(name: str) -> None:
    joints = ("joint_1", "joint_2", name, "joint_4", "joint_5")
    result = made.backlash(name, joints)
    result.unexplained.append(Unexplained("wire", [name], "always", 0.2, [name], f"{name}: 20% is left."))
    result.quality = {name: result.quality["run1"] | {"notes": [name]}}
    result.provenance["bags"] = [name]
    page = render(result)
    plain = render(made.backlash())
    assert {tag for tag, _ in Page(page).tags} <= {tag for tag, _ in Page(plain).tags} | {"ul", "li"}
    drawn = [element.tag for picture in pictures(page) for element in ElementTree.fromstring(picture).iter()]
    assert drawn
    assert not any(tag.endswith(("}script", "}img", "}u")) for tag in drawn)
    assert name.split("<")[-1].rstrip(">") in "".join(t for ts in Page(page).text.values() for t in ts)
    assert "49" not in re.findall(r"<h1>.*</h1>", page)[0]


def test_a_path_that_is_not_text_does_not_stop_the_report(found: Diagnosis, tmp_path: Path) -> None:
    write(replace(found, provenance={"bags": ["run\udcff"]}), tmp_path / "report.html")
    assert "run?" in (tmp_path / "report.html").read_text(encoding="utf-8")


def test_every_part_of_the_report_is_there(page: str) -> None:
    text = words(page)
    assert re.findall("<h2[^>]*>(.*)</h2>", page) == PARTS
    assert "trunk_ros diagnose run1 --output out" in text
    assert "The end is cut off." in text
    assert "1, longest 400 ms at 12.0 s" in text
    assert "39" in text
    assert "3 duplicates" in text
    assert "100 Hz" in text


def test_values_have_spreads_and_sensible_units(page: str) -> None:
    assert "1.0000 ± 0.0023 mrad" in words(page)


def test_rivals_are_listed_nearest_first_with_what_they_would_show(found: Diagnosis) -> None:
    card = found.findings[0]
    evidence = {**card.evidence, "rivals": {"friction_wear": 5000.0, "presliding_hysteresis": 3.0}}
    card = replace(card, evidence=evidence, equivalents=["presliding_hysteresis"])
    text = words(page_of(replace(found, findings=[card])))
    assert text.index("presliding hysteresis 0.00") < text.index("friction wear 0.8")
    assert "; would show: a square wave with the sign of the motion that grows with time" in text
    assert "These data cannot tell it from presliding hysteresis." in text
    assert "No motion was designed" in text


def test_an_experiment_says_what_to_run(found: Diagnosis) -> None:
    proposal = {
        "separates": ["backlash", "tension_error"],
        "statement": "Compare joints.",
        "trajectory": "a.yaml",
    }
    text = words(page_of(replace(found, experiments=[proposal])))
    assert "Compare joints. Separates backlash from tension error." in text
    assert "--trajectory a.yaml" in text
    text = words(page_of(replace(found, experiments=[proposal | {"trajectory": ""}])))
    assert "Compare joints." in text
    assert "Separates" not in text


def test_what_is_left_is_framed_in_the_map_and_named_in_the_verdict(found: Diagnosis) -> None:
    wire = found.stages["wire"]["joints"]
    left = {**wire, "joint_2": {**wire["joint_2"], "rmse_before": 3e-4, "rmse_after": 3e-4}}
    stages = {**found.stages, "wire": {**found.stages["wire"], "joints": left}}
    rest = [Unexplained("wire", ["joint_2"], "time", 0.5, ["time"], "joint_2: half of it is left.")]
    page = page_of(replace(found, stages=stages, unexplained=rest))
    assert page.count(" rest") >= 1
    assert re.search(r'class="heat2 rest">0\.300.mrad <small class="times">3\.0', page)
    assert "Not fully explained on: joint_2." in words(page)
    assert "joint_2: half of it is left." in words(page)


@pytest.mark.parametrize(
    "regime", ["always", "posture", "reversal", "hold", "low_speed", "high_speed", "time"]
)
def test_every_regime_has_a_signature_also_of_effects_that_nobody_knows(regime: str) -> None:
    result = made.backlash()
    unheard = replace(result.findings[0], effect="of_the_users_own", regime=regime, depends_on=[])
    page = page_of(replace(result, findings=[unheard]))
    assert 'alt="Signature of of the users own"' in page


def test_a_residual_below_the_steps_of_the_encoder_is_said_to_be_that_and_not_coloured() -> None:
    clean = made.diagnosis({}, [])
    for said in clean.stages["wire"]["joints"].values():
        said |= {"rmse_before": 8e-6, "rmse_after": 8e-6, "noise_floor": 2e-7, "resolution": 8.6e-6}
    text = words(page_of(clean))
    assert "No effect is missing: the residual that remains (8.00 µrad rms) is below a step of" in text
    assert [cell.heat for _, cells in maps(clean)[0].rows for cell in cells] == [0] * 5
    assert "8.00 µrad 0.9 × encoder steps" in text
    assert "0.200 µrad 8.60 µrad" in text
    clean.stages["wire"]["joints"]["joint_2"] |= {
        "rmse_before": 1e-4,
        "rmse_after": 1e-4,
        "noise_floor": 1e-4,
    }
    mixed = words(page_of(clean)).replace("&#39;", "'")
    assert (
        "what remains (0.100 mrad rms at most) is no more than the sensors' noise and encoder steps" in mixed
    )


def test_the_doubt_stands_in_the_headline_behind_the_effect_that_is_in_the_model() -> None:
    doubtful = made.backlash()
    (finding,) = doubtful.findings
    evidence = {**finding.evidence, "rivals": {"stribeck_friction": -3.0, "cogging": 5.0}}
    rivals = ["cogging", "stribeck_friction"]
    doubtful.findings = [replace(finding, equivalents=rivals, evidence=evidence)]
    text = words(page_of(doubtful))
    assert "either backlash, cogging or stribeck friction (joint_3, " in text
    assert "backlash, cogging or stribeck friction: joint_3" in text
    said = next(line for line in spoken(doubtful) if "joint_3" in line)
    assert said.startswith("  backlash or cogging or stribeck_friction (90% that it is one of these")


def test_names_that_stand_together_are_bracketed_in_the_headline_beside_other_findings() -> None:
    result = made.backlash()
    open_ = replace(result.findings[0], equivalents=["cogging", ["stribeck_friction", "viscous_lag"]])
    coupled = replace(result.findings[0], effect="joint_coupling")
    text = words(page_of(replace(result, findings=[coupled, open_])))
    several = "either backlash, cogging or (stribeck friction + viscous lag) (joint_3, "
    assert re.search(rf"joint coupling \(joint_3, \d+%\) and {re.escape(several)}", text)


def test_findings_without_plots_are_told_all_the_same() -> None:
    tilt = made.finding(
        "base_tilt", [], {"arm": {"angle": made.value(2e-3, 1e-5)}}, stage="arm", regime="always"
    )
    result = made.diagnosis({}, [tilt])
    tip = {"unit": "m", "rmse_before": 4e-4, "rmse_after": 3e-5, "noise_floor": 3e-5}
    result.stages["arm"] = {"compared": True, "tip": {"y": tip}}
    text = words(page_of(result))
    assert "base tilt (the tip, 90%)" in text
    assert "2.000 ± 0.010 mrad" in text
    assert "13.3 → 1.0" in text
    result.plots = {}
    assert "2.000 ± 0.010 mrad" in words(page_of(result))


def test_joints_that_slide_are_in_millimetres(found: Diagnosis) -> None:
    joints = {name: {**said, "unit": "m"} for name, said in found.stages["wire"]["joints"].items()}
    stages = {**found.stages, "wire": {**found.stages["wire"], "joints": joints}}
    drawn = "".join(pictures(render(replace(found, stages=stages))))
    assert "residual along the motion / mm" in drawn
    assert "mrad" not in drawn


def test_the_same_diagnosis_gives_the_same_page(found: Diagnosis, page: str) -> None:
    assert render(found) == page


def test_five_joints_with_three_findings_are_drawn_in_two_megabytes() -> None:
    every = np.ones(5)
    effects = {"ratio_error": {"relative": 0.01 * every}, "backlash": {"half_width": 1e-3 * every}}
    findings = [made.finding(name, list(made.JOINTS), {}) for name in (*effects, "unknown")]
    result = made.diagnosis(effects, findings)
    page = render(result)
    assert len(page) < 2_000_000
