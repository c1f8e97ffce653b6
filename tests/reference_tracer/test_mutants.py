"""Small deliberate faults, one line each: the tests have to notice every one of them.

A mutant is the source of a module with one passage replaced, put in place of the original for the length of one check;
the check is a test of this suite, which passes on the original. A mutant whose passage is gone, because the code has
changed, needs a new one.
"""

import importlib
import importlib.util
import inspect
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from types import FunctionType

import pytest
import test_camera as camera
import test_decisions as decisions
import test_formulas as formulas
import test_image_files as image_files
import test_odd_parts as odd_parts
import test_refraction as refraction
import test_shading as shading
import test_surfaces as surfaces
import test_ties as ties
import test_wavefront_against_recursion as against_recursion

from raytruth import reference_tracer
from raytruth.reference_tracer.errors import InputError


@dataclass
class Mutant:
    right: str  # stands once in the fast tracer's files
    wrong: str
    check: Callable
    arguments: tuple = ()


MUTANTS = {
    # sections 2 and 5
    "C1 rows from the bottom": Mutant(
        "f.ratio * (-(row + (sample_row + 0.5) / samples) + f.height * 0.5)",
        "f.ratio * ((row + (sample_row + 0.5) / samples) - f.height * 0.5)",
        camera.test_C1_row_zero_is_the_top_row_and_columns_run_to_the_right),
    "C1 mirrored": Mutant(
        "_cross(self.up, v_dir)", "_cross(v_dir, self.up)",
        camera.test_C1_row_zero_is_the_top_row_and_columns_run_to_the_right),
    "C1 field of view over the shorter side": Mutant(
        "ratio=span / max(camera.width", "ratio=span / min(camera.width",
        camera.test_C1_the_longer_side_spans_the_field_of_view, (60.0, 48, 36)),
    "C2 samples at the corners": Mutant(
        "(sample_col + 0.5) / samples", "sample_col / samples",
        camera.test_C2_samples_lie_on_a_regular_grid_of_sub_pixel_centres),
    "P1 truncated": Mutant(
        "* 255 + 0.5", "* 255",
        image_files.test_P1_eight_bits_clamp_and_round_to_nearest_without_gamma),
    # sections 3 and 7
    "O1 the flip forgotten in kernels": Mutant(
        '-1.0 if surface.inside == "positive" else 1.0', "1.0",
        decisions.test_N1_the_normal_is_turned_against_the_ray, ("positive", "exact")),
    "O2 plane turned over": Mutant(
        "x * a + y * b + z * c", "-(x * a + y * b + z * c)",
        surfaces.test_O2_planes_and_paraboloids_are_half_open_solids),
    "O2 paraboloid turned over": Mutant(
        "x**2 / a**2 + y**2 / b**2 - z", "z - x**2 / a**2 - y**2 / b**2",
        surfaces.test_O2_planes_and_paraboloids_are_half_open_solids),
    "O3 turned the other way": Mutant(
        "+ sin * cross", "- sin * cross", decisions.test_O3_objects_are_turned_about_their_centre,
        ("exact",)),
    "O4 polynomial torus": Mutant(
        "(sqrt(x**2 + y**2) - R) ** 2 + z**2 - r**2",
        "(x**2 + y**2 + z**2 + R**2 - r**2) ** 2 - (x**2 + y**2) * (R**2 * 4)",
        decisions.test_O4_a_spindle_torus_is_crossed_twice, ("exact",)),
    "O5 nine two-hundredths": Mutant(
        "z**2 * y**3 * 9 / 80", "z**2 * y**3 * 9 / 200",
        surfaces.test_O5_the_heart_s_constant_is_nine_eightieths),
    "O6 the sign of the constant dropped": Mutant(
        "self.sign *= 1 if value > 0 or m % 2 == 0 else -1", "pass",
        odd_parts.test_O6_the_regular_form_has_the_sign_of_f),
    "O6 the sign of an expansion dropped": Mutant(
        "self.sign *= 1 if constant > 0 else -1", "pass",
        odd_parts.test_O6_the_regular_form_has_the_sign_of_f),
    "O6 a factor of even multiplicity kept": Mutant(
        "if m % 2 or not (is_defined(tree) and zeros_are_thin(tree))]", "]",
        odd_parts.test_O6_a_formula_that_never_changes_sign_has_no_surface, (f"{odd_parts.BALL}**2", "exact")),
    "O6 an even multiplicity of an expansion kept": Mutant(
        "for q, m in factors if m % 2 and q.total_degree() > 0", "for q, m in factors if q.total_degree() > 0",
        odd_parts.test_O6_the_regular_form_has_the_sign_of_f),
    "one family whatever the whole exponents": Mutant(
        'return f"{written(base)}**{n}" if n >= 0', 'return f"{written(base)}**n" if n >= 0',
        formulas.test_numbers_are_no_part_of_a_family_but_exponents_and_structure_are),
    "one family with and without bounds": Mutant(
        "{'' if self.box() else ' without bounds'}", "",
        formulas.test_what_chooses_a_method_is_the_same_in_a_whole_family),
    # sections 4.1 and 4.2
    "M1 a double root is a hit": Mutant(
        "enters = (self.half_squared > 0)", "enters = (self.half_squared >= 0)",
        decisions.test_M1_a_ray_that_only_touches_has_not_hit, ("exact",)),
    "M2 samples counted from the box": Mutant(
        "dr.floor(known / self.step_size) - 1", "known / self.step_size",
        decisions.test_M2_samples_lie_at_multiples_of_the_step_counted_from_one),
    "M2 side read off f": Mutant(
        "ray.sides.test(member.index), limit)",
        "member.solid.inside_at(member.local(ray.o, ray.d), 0.0), limit)",
        decisions.test_M2_the_side_at_the_start_is_told_and_not_read_off_f, ("exact",)),
    "M3 refraction keeps its side": Mutant(
        "self.words[0] ^ (bits(1) << bit)", "self.words[0]",
        refraction.test_M3_a_ball_turns_rays_twice_by_the_same_angle, ("exact",)),
    "M3 the camera is always outside": Mutant(
        "is_inside(o, self.scene.camera.position, self.literal(o))", "False",
        decisions.test_M3_a_camera_ray_starts_with_the_sign_of_f_at_the_camera, ("exact",)),
    "M3 an epsilon": Mutant(
        "Ray(pick(arrays.Vector, parents.point, active), d, sides, left)",
        "Ray(pick(arrays.Vector, parents.point, active) + d * 1e-4, d, sides, left)",
        decisions.test_M3_nothing_is_offset_by_an_epsilon, ("exact",)),
    "M4 the first in the scene's order": Mutant(
        "((c.order < order) | ((c.order == order) & earlier))", "(c.order < order)",
        decisions.test_M4_of_several_changes_in_one_step_the_nearest_counts, ("sphere", (0, 1))),
    "M4 the last of equal objects": Mutant(
        "(member.index < index)", "(member.index > index)",
        ties.test_M4_the_literal_method_takes_the_first_of_two_equal_objects_and_decides, ("sphere", "sphere")),
    "M4 the last of those that tie": Mutant(
        "dr.minimum(first, member.index)", "member.index", ties.test_M4_coplanar_faces, ("exact",)),
    "M4 the nearest of the computed distances": Mutant(
        "dr.select(crossed, first, index)", "index",
        ties.test_M4_of_one_ball_twice_the_first_is_seen_and_its_pixels_are_undecided, ("sphere", "formula")),
    "M4 ties decided": Mutant(
        "undecided | ~crossed | (tied > 1)", "undecided | ~crossed",
        ties.test_M4_of_one_ball_twice_the_first_is_seen_and_its_pixels_are_undecided, ("sphere", "sphere")),
    "M4 everything near is undecided": Mutant(
        "(tied > 1)", "(tied > 0)", ties.test_M4_what_is_decided_of_near_ties_is_right, ("spheres", 1e-12)),
    "M4 nobody looks beyond the nearest": Mutant(
        "limit = margin.end(order) if looks_beyond else order", "limit = order",
        ties.test_M4_the_order_of_the_scene_counts_and_not_that_of_families_or_clusters,
        ("interval", ("formula", "sphere"))),
    "M5 rays of twice the length": Mutant(
        "dr.select(usable, self.range_of(ray), 0)", "dr.select(usable, 2 * self.range_of(ray), 0)",
        decisions.test_M5_every_ray_ends_at_max_distance_counted_anew, ("exact",)),
    "M5 shadow rays beyond the light": Mutant(
        "distance, faces)", "2 * distance, faces)",
        shading.test_M5_a_shadow_ray_ends_at_its_light, ("exact",)),
    "M6 one Newton step": Mutant(
        "(iteration < self.max_iterations)", "(iteration < 1)",
        decisions.test_M6_newton_runs_as_written, (1e-12, 20)),
    "M6 stop on |g|": Mutant(
        "(dr.abs(dt) > self.tolerance * dr.maximum(1, dr.abs(t)))",
        "(dr.abs(g) > self.tolerance)",
        decisions.test_M6_newton_s_stop_does_not_depend_on_the_scale_of_f, ("1e-9",)),
    "M6 Newton kept within its step": Mutant(
        "t = dr.select(finite, t - dt, t)",
        "t = dr.select(finite, dr.clip(t - dt, step_end - h, step_end), t)",
        decisions.test_M6_newton_runs_as_written, (1e-12, 20)),
    "M7 exact keeps silent": Mutant(
        "return Scan(t, end, guess, regular, count, undecided, segments)",
        "return Scan(t, end, guess, regular, count, Bool(False), segments)",
        decisions.test_M7_the_exact_method_says_that_it_cannot_tell, ("1 + sqrt(4 - z)",)),
    # section 4.3
    "N1 not turned": Mutant(
        "return dr.select(cos1 < 0, -gradient, gradient), ", "return gradient, ",
        decisions.test_N1_the_normal_is_turned_against_the_ray, ("negative", "exact")),
    "L1 the last light alone": Mutant(
        "else illumination + light", "else light",
        shading.test_L1_lights_add_up_by_channel_and_do_not_fall_off, ("exact",)),
    "L1 falling off": Mutant(
        "cos * intensity, 0)", "cos * intensity / (distance * distance), 0)",
        shading.test_L1_lights_add_up_by_channel_and_do_not_fall_off, ("exact",)),
    "L2 negative light": Mutant(
        "active & (cos > 0)", "active",
        shading.test_L2_a_light_behind_the_surface_adds_nothing, ("exact",)),
    "L3 once for an object": Mutant(
        "_multiply_repeatedly(intensity, transparency, crossings)",
        "dr.select(crossings > 0, intensity * transparency, intensity)",
        shading.test_L3_light_is_weakened_at_every_crossing, ("exact",)),
    "4.3.2 reflected the other way": Mutant(
        "d + normal * (2 * cos1)", "d - normal * (2 * cos1)",
        shading.test_reflection_obeys_the_mirror_law, ("exact",)),
    "E1 as printed": Mutant(
        "n2 / n1 if as_printed else n1 / n2", "n2 / n1", refraction.test_snell_s_law, (1, 1.5)),
    "R1 always entering": Mutant(
        "n1, n2 = dr.select(leaving, n, 1), dr.select(leaving, 1, n)", "n1, n2 = 1, n",
        refraction.test_a_slab_shifts_rays_and_does_not_turn_them, (1.5, "exact")),
    "R2 total at equality": Mutant(
        "total = sin1 > n2 / n1\n", "total = sin1 >= n2 / n1\n",
        refraction.test_R2_at_the_critical_angle_itself_it_refracts),
    "R3 total reflection for nothing": Mutant(
        "dr.select(interaction.total_reflection, T, 0)", "dr.select(interaction.total_reflection, 0 * T, 0)",
        refraction.test_R3_total_reflection_keeps_the_weight_of_refraction, ("exact",)),
    "R3 traced twice": Mutant(
        "dr.select(met & ~refraction.total, T, 0)", "dr.select(met, T, 0)",
        refraction.test_R3_total_reflection_keeps_the_weight_of_refraction, ("exact",)),
    "R4 not renormalised": Mutant(
        "dr.normalize(world.optics.reflect(ray.d, normal, cos1))", "world.optics.reflect(ray.d, normal, cos1)",
        decisions.test_R4_directions_stay_of_unit_length_through_sixty_reflections, ("exact",)),
    "4.3.4 visible colour not dimmed by transparency": Mutant(
        "(1.0 - reflection) * (1.0 - transparency)", "1.0 - reflection",
        shading.test_the_three_rays_are_mixed_with_the_printed_weights, (0.3, 0.6, "exact")),
    "D1 one generation less": Mutant(
        "generation == self.world.scene.tracing.max_depth",
        "generation >= self.world.scene.tracing.max_depth - 1",
        shading.test_D1_a_mirror_box_is_a_geometric_series, (0.5, 7, "exact")),
    "D1 black beyond the last": Mutant(
        "if any(world.scene.background)", "if False",
        shading.test_D1_a_mirror_box_is_a_geometric_series, (0.5, 7, "exact")),
    "D2 black background": Mutant(
        "dr.select(active, background, 0)", "0.0",
        shading.test_D2_rays_that_hit_nothing_see_the_background, ("exact",)),
}

EVERY_RULE = against_recursion.test_paper_on_small_scenes, ("every function",)
ORACLE = {  # what the fast tracer derives: the oracle has its own, and tells
    "sides": Mutant("-np.inf < value < 0", "-np.inf < value < 50",
                    against_recursion.test_paper_on_small_scenes, ("balls of glass and of mirror",)),
    "rotation": Mutant("+ sin * cross", "- sin * cross", against_recursion.test_exact_on_small_scenes,
                       ("turned quadrics",)),
    "sine": Mutant("self._chain(fn.sin(self.value), fn.cos(self.value))",
                   "self._chain(fn.sin(self.value), -fn.cos(self.value))", *EVERY_RULE),
    "exponential": Mutant("return self._chain(power, power)", "return self._chain(power, power * 1.001)", *EVERY_RULE),
    "product": Mutant("_plus(_times(da, other.value), _times(db, self.value))",
                      "_plus(_times(da, self.value), _times(db, other.value))", *EVERY_RULE),
    "power": Mutant("n * fn.whole_power(self.value, n - 1)", "fn.whole_power(self.value, n - 1)", *EVERY_RULE),
    "larger": Mutant("else fn.where_larger(self.value, other.value,", "else fn.where_larger(other.value, self.value,",
                     *EVERY_RULE),
}


def put_in_place(mutant: Mutant, folder: Path, monkeypatch) -> None:
    """Replaces the functions and methods of one module by those of its mutant, wherever they have been imported."""
    package = Path(reference_tracer.__file__).parent
    sources = {path: path.read_text("utf-8") for path in package.rglob("*.py")
               if path.name != "recursive.py" and path.parent.name != "certify"}  # programs of their own
    assert sum(source.count(mutant.right) for source in sources.values()) == 1, f"no single place for {mutant.right!r}"
    found = next(path for path, source in sources.items() if mutant.right in source)
    name = ".".join(["raytruth", "reference_tracer", *found.relative_to(package).with_suffix("").parts])
    original, path = importlib.import_module(name), folder / found.name
    path.write_text(sources[found].replace(mutant.right, mutant.wrong), "utf-8")
    spec = importlib.util.spec_from_file_location(name, path)
    wrong = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(wrong)
    for key, value in list(vars(original).items()):
        if getattr(value, "__module__", None) != name:
            continue
        if inspect.isclass(value):
            of_mutant = getattr(wrong, key)
            setattr(wrong, key, value)  # its functions meet objects of the original class
            for attribute, member in vars(of_mutant).items():
                if isinstance(member, (FunctionType, staticmethod, classmethod, property)):
                    monkeypatch.setattr(value, attribute, member)
        else:
            for user, module in list(sys.modules.items()):
                if user.startswith(("raytruth.reference_tracer", "test_", "tracing_support")) and vars(module).get(key) is value:
                    monkeypatch.setattr(module, key, getattr(wrong, key))


@pytest.fixture(autouse=True)
def nothing_remembered():
    """What surfaces remember of a formula was found by right code before a mutant, and by wrong code after it."""
    def forget():
        for name, module in list(sys.modules.items()):
            if name.startswith("raytruth.reference_tracer.surfaces"):
                for function in vars(module).values():
                    if hasattr(function, "cache_clear"):
                        function.cache_clear()

    forget()
    yield
    forget()


@pytest.mark.parametrize("name", MUTANTS)
def test_the_tests_notice_a_mutant(name, tmp_path, monkeypatch):
    mutant = MUTANTS[name]
    put_in_place(mutant, tmp_path, monkeypatch)
    with pytest.raises((AssertionError, ValueError)) as noticed:
        mutant.check(*mutant.arguments)
    assert not isinstance(noticed.value, InputError)  # that would be a check asked wrongly


@pytest.mark.parametrize("name", ORACLE)
def test_the_oracle_notices_a_mutant_of_what_it_does_not_share(name, tmp_path, monkeypatch):
    """Derivatives, sides and rotations of recursive.py are its own: a fault in the fast tracer's parts the two."""
    mutant = ORACLE[name]
    put_in_place(mutant, tmp_path, monkeypatch)
    with pytest.raises(AssertionError):
        mutant.check(*mutant.arguments)


@pytest.mark.parametrize("name", ["E1 as printed", "L3 once for an object", "O2 plane turned over",
                                  "M6 one Newton step"])
def test_the_checks_pass_on_the_original_put_in_place_in_the_same_way(name, tmp_path, monkeypatch):
    """What the mutants' checks notice is the fault, not the manner of its insertion."""
    mutant = MUTANTS[name]
    put_in_place(replace(mutant, wrong=mutant.right), tmp_path, monkeypatch)
    mutant.check(*mutant.arguments)
