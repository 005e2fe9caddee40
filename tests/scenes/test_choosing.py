"""Overlapping proposals: which become objects, and whose points are whose."""

from __future__ import annotations

import numpy as np

from spherefunc_bullet.function_model import Membership
from spherefunc_bullet.scenes.recognition.proposals import CLUSTERS, POOLS, Proposal, shared_points
from spherefunc_bullet.scenes.recognition.room import THRESHOLDS, ObjectCandidate, choose_objects, with_claims


def candidate(place: int, by: str, members: range, *, on_top: bool = False, **scores: float) -> ObjectCandidate:
    answer = {
        name: Membership(member=scores.get(name, 0.0) > 0.5, score=scores.get(name, 0.0), radius=0.02)
        for name in ("cup", "sittable", "table")
    }
    proposal = Proposal(by=by, members=np.arange(members.start, members.stop), support=0.0, on_top=on_top)
    return ObjectCandidate(proposal=proposal, functions=answer, place=place)


def claims(candidates: list[ObjectCandidate]) -> list[tuple[str, int]]:
    return [(min(one.claimed, default="none"), len(one.proposal.members)) for one in choose_objects(candidates, 10)]


def test_the_surer_of_two_claims_of_one_thing_stays():
    two = [candidate(0, CLUSTERS, range(0, 100), table=0.6), candidate(1, POOLS, range(20, 110), sittable=0.8)]
    assert claims(two) == [("sittable", 90)]


def test_a_blob_gives_way_to_the_pools_in_it():
    blob = candidate(0, CLUSTERS, range(0, 1000), table=0.55)
    pools = [candidate(1, POOLS, range(0, 500), table=0.9), candidate(2, POOLS, range(500, 700), sittable=0.8)]
    assert claims([blob, *pools]) == [("table", 500), ("sittable", 200)]


def test_the_whole_goes_before_a_pool_that_is_half_of_it_and_as_sure():
    sofa, half = candidate(0, CLUSTERS, range(0, 1000), sittable=0.97), candidate(1, POOLS, range(0, 450), sittable=1.0)
    assert claims([sofa, half]) == [("sittable", 1000)]


def test_a_cup_on_a_table_keeps_its_points_and_the_table_its_own():
    table, cup = candidate(0, CLUSTERS, range(0, 1000), table=0.7), candidate(1, POOLS, range(900, 960), cup=0.6)
    assert claims([table, cup]) == [("table", 940), ("cup", 60)]


def test_a_pool_in_a_cluster_that_it_mostly_is_takes_the_cluster_s_points():
    cluster, pool = candidate(0, CLUSTERS, range(0, 100), table=0.45), candidate(1, POOLS, range(0, 70), table=0.7)
    assert claims([cluster, pool]) == [("table", 100)]


def test_clusters_without_a_function_stay_objects_and_pools_do_not():
    plain = [candidate(0, CLUSTERS, range(0, 100)), candidate(1, POOLS, range(200, 300))]
    assert claims(plain) == [("none", 100)]


def test_what_stands_on_a_table_is_an_object_once_without_a_function_too():
    table, tin = candidate(0, CLUSTERS, range(0, 1000), table=0.7), range(900, 960)
    apart = [candidate(k, POOLS, own, on_top=True) for k, own in ((1, range(900, 930)), (2, tin))]
    assert claims([table, *apart]) == [("table", 940), ("none", 60)]
    assert claims([table, candidate(1, POOLS, tin, on_top=True), candidate(2, POOLS, tin, cup=0.9)]) == [
        ("table", 940), ("cup", 60),
    ]  # fmt: skip


def test_what_claims_leave_too_little_of_is_no_object():
    cluster, pool = candidate(0, CLUSTERS, range(0, 100)), candidate(1, POOLS, range(0, 45), cup=0.9)
    assert claims([cluster, pool]) == [("none", 55), ("cup", 45)]
    assert claims([cluster, candidate(1, POOLS, range(0, 95), cup=0.9)]) == [("cup", 100)]


def test_a_seat_that_is_a_cluster_needs_a_lower_score_than_what_else_is_claimed():
    answer = candidate(0, CLUSTERS, range(100), table=0.45, cup=0.45, sittable=0.45).functions
    claimed = {
        by: {name for name, one in with_claims(answer, THRESHOLDS[by]).items() if one.member} for by in THRESHOLDS
    }
    assert claimed == {CLUSTERS: {"sittable"}, POOLS: set()}


def test_shared_points_are_counted():
    one, other = (Proposal(by=POOLS, members=np.array(own), support=0.0) for own in ([1, 4, 9], [0, 4, 9, 12]))
    assert shared_points(one, other) == shared_points(other, one) == 2
