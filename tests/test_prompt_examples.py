"""The examples that prompts give of the simulator: what they say happens when they are carried out."""

import re

import pytest
from folding_prompts import prompt, tool_description
from folding_server.simulator import Paper, add_vertex, fold, new_paper
from folding_server.simulator.state_diff import state_difference

EXAMPLE = re.compile(r"`fold\(\[(\d+), (\d+)\], (-?1)\)`")
SAYING = {
    "tools/fold": tool_description("fold"),
    "variants/plan_system": prompt("variants/plan_system", front="red", back="white"),
}


def halved() -> Paper:
    """The sheet with its upper half folded down, as the prompts have it: 1 on 4, 2 on 3, crease 5-6."""
    return fold(add_vertex(add_vertex(new_paper(), (1, 4), 0.5), (2, 3), 0.5), (5, 6), 1)


@pytest.mark.parametrize("text", SAYING.values(), ids=SAYING)
def test_ids_of_the_upper_layer_fold_it_alone_and_those_of_the_lower_fold_both(text: str) -> None:
    paper = halved()
    places = paper.folded_vertices_coords
    assert "1 on 4, 2 on 3, crease 5-6" in " ".join(text.split())
    assert (places[1], places[2]) == (pytest.approx(places[4]), pytest.approx(places[3]))
    assert paper.is_folded((5, 6))
    one, both = EXAMPLE.findall(text)
    turned = []
    for u, v, direction in (one, both):
        after = fold(paper, (int(u), int(v)), int(direction))
        turned.append(len(state_difference(paper, after).moved_faces))
        assert {paper.folded_vertices_coords[int(u)], paper.folded_vertices_coords[int(v)]} == {
            (0.0, 0.0),
            (1.0, 0.5),
        }
    assert turned == [1, 2]


def test_the_state_s_description_does_not_say_that_any_of_several_ids_will_do() -> None:
    said = " ".join(tool_description("get_current_state").split())
    assert "any of them" not in said
    assert "the topmost face that has both" in said
