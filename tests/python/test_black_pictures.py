"""A black picture says why, in one line."""

import warnings

import pytest

import cpm

OPTIONS = dict(size=(8, 6), photons=2000, nearest=10, wavelengths=[550.0])
FLOOR = ([(-1, 0, -1), (1, 0, -1), (0, 0, 1)], [(0, 2, 1)])


def scene(light=True, floor=True, looks_away=False, intensity=1.0, target=(0, 0, 0)):
    made = cpm.Scene()
    if floor:
        made.add_mesh(*FLOOR, cpm.materials.Diffuse(0.5))
    if light:
        made.add_light(cpm.lights.Spot((0, 1, 0), target, 20.0, intensity))
    made.camera = cpm.Camera.look_at((0, 2, 2), (0, 4, 4) if looks_away else (0, 0, 0))
    return made


@pytest.mark.parametrize("made, options, cause", [
    (scene(light=False), {}, "no lights"),
    (scene(), {"photons": 0}, "photons is 0"),
    (scene(floor=False), {}, "no shapes"),
    (scene(intensity=([600, 601], [0, 1])), {}, "no light emits at these wavelengths"),
    (scene(target=(0, 5, 0)), {}, "no photon met a diffuse surface"),
    (scene(looks_away=True), {}, "no eye ray meets a surface"),
], ids=["lights", "photons", "shapes", "dark light", "aim", "camera"])
def test_black(made, options, cause):
    with pytest.warns(UserWarning, match="the picture is black: ") as caught:
        cpm.render(made, **OPTIONS | options)
    assert len(caught) == 1 and cause in str(caught[0].message)


def test_a_lit_picture_is_silent():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        cpm.render(scene(), **OPTIONS)


def test_on_the_command_line(tmp_path, monkeypatch, capsys):
    from cpm.cli.program import run

    monkeypatch.chdir(tmp_path)
    (tmp_path / "dark.toml").write_text(
        '[[shapes]]\ntype = "sphere"\ncenter = [0, 0, 0]\nradius = 1\nmaterial = { type = "black" }\n'
        "[camera]\norigin = [0, 0, 3]\ntarget = [0, 0, 0]\n")
    assert run(["render", "dark.toml", "--size", "8x6", "--photons", "100", "-q"]) == 0
    assert capsys.readouterr().err == ("cpm: warning: the picture is black: the scene has no lights (Scene.add_light, "
                                       "[[lights]])\n")
