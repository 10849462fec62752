"""Patterns of our own making: their verdicts and numbers of layer orders, and what is wrong with broken ones."""

import networkx as nx
import pytest
from folding_server.simulator.foldability import CreasePattern, check_pattern
from known_patterns import (
    KNOWN,
    TWISTS,
    Known,
    flipped,
    inner,
    map_of,
    miura,
    moved,
    random_map,
    strip,
    twist,
    waterbomb,
)
from plain_layers import count_orders

EACH = pytest.mark.parametrize("known", KNOWN, ids=lambda known: known.name)
SOUND = {"Miura": miura(3, 3, 0.05), "map": random_map(3, 3, 1), "twist": twist(4, 1.0, "VM")}
STAMPS = {2: 2, 3: 6, 4: 16, 5: 50}
"""Ways to fold a strip of stamps (OEIS A000136)."""
MAPS = {(2, 2): 8, (2, 3): 60}
"""Ways to fold a map (OEIS A001415)."""


@EACH
def test_a_pattern_has_its_verdict_and_number_of_orders(known: Known) -> None:
    report = check_pattern(known.pattern)
    assert (report.foldable, report.states, report.capped) == (known.orders > 0, known.orders, False)
    assert not report.violations


@EACH
def test_trying_all_orders_finds_as_many(known: Known) -> None:
    assert count_orders(known.pattern) == known.orders


@EACH
def test_faces_found_from_the_edges_do_as_well(known: Known) -> None:
    given = known.pattern
    bare = CreasePattern(given.vertices_coords, given.edges_vertices, given.edges_assignment)
    assert sorted(map(sorted, bare.cycles)) == sorted(map(sorted, given.faces_vertices))
    assert check_pattern(bare).states == known.orders


@pytest.mark.parametrize(("stamps", "ways"), STAMPS.items())
def test_trying_all_orders_finds_the_known_ways_to_fold_stamps(stamps: int, ways: int) -> None:
    assert count_orders(strip((1,) * stamps, "U" * (stamps - 1))) == ways


@pytest.mark.parametrize(("size", "ways"), MAPS.items())
def test_trying_all_orders_finds_the_known_ways_to_fold_a_map(size: tuple[int, int], ways: int) -> None:
    columns, rows = size
    assert count_orders(map_of(columns, rows, "U" * ((columns - 1) * rows + (rows - 1) * columns))) == ways


@pytest.mark.parametrize("name", TWISTS)
def test_the_layers_of_a_twist_go_round_in_a_circle(name: str) -> None:
    report = check_pattern(TWISTS[name])
    assert report.stack is None
    assert not nx.is_directed_acyclic_graph(nx.DiGraph(report.lying))


def test_a_pattern_may_fold_at_every_vertex_and_not_as_a_whole() -> None:
    report = check_pattern(twist(4, 0.4, "VM"))
    assert not report.foldable
    assert report.violations == ()
    assert "no order of the layers avoids crossings" in report.reason


@pytest.mark.parametrize("name", SOUND)
def test_a_moved_vertex_is_named_for_kawasaki(name: str) -> None:
    broken = moved(SOUND[name], 0.03 + 0.02j)
    report = check_pattern(broken)
    assert {found.condition for found in report.violations} == {"Kawasaki"}
    assert inner(broken)[0] in {found.vertex for found in report.violations}
    assert f"vertex {report.violations[0].vertex}" in report.reason


@pytest.mark.parametrize("pattern", [*SOUND.values(), waterbomb()], ids=[*SOUND, "waterbomb"])
def test_a_flipped_letter_is_named_for_maekawa(pattern: CreasePattern) -> None:
    report = check_pattern(flipped(pattern))
    assert {found.condition for found in report.violations} == {"Maekawa"}


@pytest.mark.parametrize("name", SOUND)
@pytest.mark.parametrize("by", [1e-12, 1e-10, 1e-8, 1e-6])
def test_a_vertex_out_of_place_by_next_to_nothing_is_forgiven(name: str, by: float) -> None:
    assert check_pattern(moved(SOUND[name], by * (1 + 0.5j))).states == check_pattern(SOUND[name]).states


@pytest.mark.parametrize("name", SOUND)
def test_a_vertex_out_of_place_by_what_a_hand_draws_is_forgiven_until_the_faces_do_not_close_up(
    name: str,
) -> None:
    assert check_pattern(moved(SOUND[name], 1e-4 + 5e-5j)).foldable
    assert not check_pattern(moved(SOUND[name], 1e-2 + 5e-3j)).foldable
