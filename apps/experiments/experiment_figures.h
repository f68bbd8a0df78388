#pragma once

// What an experiment tells of a run's metrics.json, in the order of its columns.
namespace gluevo::apps {

/// A figure of metrics.json.
struct Figure {
  const char* title;    // For people.
  const char* name;     // For programs.
  const char* pointer;  // Into metrics.json.
  double factor;        // For people.
  int decimals;         // For people.
};

inline constexpr Figure kAccuracy[] = {
    {"ATE SE(3), m", "ate_se3_m", "/ate_se3_m", 1.0, 4},
    {"ATE Sim(3), m", "ate_sim3_m", "/ate_sim3_m", 1.0, 4},
    {"scale", "scale", "/scale", 1.0, 4},
    {"RPE, %", "rpe_translation_percent", "/rpe_translation_percent", 1.0, 3},
    {"RPE, deg/m", "rpe_rotation_deg_per_m", "/rpe_rotation_deg_per_m", 1.0, 4},
    {"coverage, %", "coverage", "/coverage", 100.0, 1},
};
inline constexpr Figure kWithinSegments = {"ATE within segments, m", "ate_within_segments_m",
                                           "/within_segments/ate_se3_m", 1.0, 4};
inline constexpr Figure kWork[] = {
    {"resets", "resets", "/resets", 1.0, 0},
    {"matches, tracked", "matches_tracked", "/matches_per_frame/tracked", 1.0, 0},
    {"matches, stereo", "matches_stereo", "/matches_per_frame/stereo", 1.0, 0},
    {"frames/s", "frames_per_second", "/frames_per_second", 1.0, 1},
};
inline constexpr Figure kLoops[] = {
    {"ATE SE(3) with loops, m", "optimized_ate_se3_m", "/optimized/ate_se3_m", 1.0, 4},
    {"frames linked", "linked_frames", "/linked_frames", 1.0, 0},
    {"segments joined", "segments_joined", "/segments_joined", 1.0, 0},
    {"loops", "loops_closed", "/loops_closed", 1.0, 0},
};
inline constexpr Figure kInertial[] = {
    {"IMU starts, s", "imu_initialised_at_s", "/imu/initialised_at_s", 1.0, 1},
    {"gravity sigma, deg", "imu_gravity_sigma_deg", "/imu/gravity_sigma_deg", 1.0, 3},
    {"IMU residual, rotation", "imu_residual_gyroscope", "/imu/residual/gyroscope", 1.0, 2},
    {"IMU residual, velocity", "imu_residual_accelerometer", "/imu/residual/accelerometer", 1.0, 2},
};
inline constexpr Figure kForProgramsOnly[] = {
    {"", "motions", "/motions", 1.0, 0},
    {"", "correct_motions", "/correct_motions", 1.0, 0},
    {"", "motions_within_segments", "/within_segments/motions", 1.0, 0},
    {"", "correct_motions_within_segments", "/within_segments/correct_motions", 1.0, 0},
    {"", "breaks", "/within_segments/breaks", 1.0, 0},
    {"", "imu_gyroscope_noise_factor", "/imu/noise_factor/gyroscope", 1.0, 0},
    {"", "imu_accelerometer_noise_factor", "/imu/noise_factor/accelerometer", 1.0, 0},
    {"", "frames", "/frames", 1.0, 0},
    {"", "threads", "/threads", 1.0, 0},
};

}  // namespace gluevo::apps
