"""The figures of `gluevo evaluate --json` as evo (pip install evo) has them, for evo_test.

usage: evo_figures.py GROUNDTRUTH.tum ESTIMATE.tum [DELTA [all]]
"""
import copy
import json
import sys

from evo.core import metrics, sync
from evo.tools import file_interface

groundtruth = file_interface.read_tum_trajectory_file(sys.argv[1])
estimate = file_interface.read_tum_trajectory_file(sys.argv[2])
delta = int(sys.argv[3]) if len(sys.argv) > 3 else 1
groundtruth, estimate = sync.associate_trajectories(groundtruth, estimate, max_diff=0.01)

figures = {"pairs": estimate.num_poses}
for name, with_scale in (("ate_se3_m", False), ("ate_sim3_m", True)):
    aligned = copy.deepcopy(estimate)
    _, _, scale = aligned.align(groundtruth, correct_scale=with_scale)
    error = metrics.APE(metrics.PoseRelation.translation_part)
    error.process_data((groundtruth, aligned))
    figures[name] = error.get_statistic(metrics.StatisticsType.rmse)
    figures["scale"] = scale
for name, relation in (
    ("rpe_frames_translation_m", metrics.PoseRelation.translation_part),
    ("rpe_frames_rotation_deg", metrics.PoseRelation.rotation_angle_deg),
):
    error = metrics.RPE(relation, delta=delta, delta_unit=metrics.Unit.frames,
                        all_pairs=len(sys.argv) > 4)
    error.process_data((groundtruth, estimate))
    figures[name] = error.get_statistic(metrics.StatisticsType.rmse)
print(json.dumps(figures))
