#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "gluevo/vo/core/trajectory.h"
#include "gluevo/vo/evaluation/evaluation.h"
#include "gluevo/vo/mapping/loop_closer.h"
#include "gluevo/vo/pipeline/odometry.h"
#include "strip.h"

namespace gluevo::apps {

/// What a report says of a network's weights.
struct WeightsLine {
  std::string network;   ///< "SuperPoint", ...
  std::string name;      ///< File, or "built in".
  std::string checksum;  ///< SHA-256, hexadecimal.
};

/// What became of a run's loops.
struct LoopLines {
  vo::Trajectory optimized;  ///< One pose a frame.
  std::vector<vo::LoopAttempt> attempts;
};

/// All that the report of a run shows. Texts are as they came: the page escapes them.
struct RunReport {
  std::string dataset;  ///< As the user named it.
  std::string method;
  std::vector<vo::FrameResult> frames;  ///< In order of time, without their tracks.
  std::vector<std::string> warnings;    ///< What a user should know about how the run went.

  vo::StereoRig rig;
  std::optional<vo::Trajectory> groundtruth;
  std::optional<vo::Evaluation> evaluation;
  std::string evaluation_failure;  ///< Why there is ground truth but no evaluation.

  /// How the inertial unit started, or why it did not, a sentence; empty where none was used.
  std::string inertial;
  /// How far the stereo calibration is off, likewise; empty where it is right.
  std::string stereo_calibration;

  double duration_s = 0.0;
  /// Milliseconds a frame by stage: "read", what vo::FrameResult names, and "total".
  std::map<std::string, std::vector<double>> stages_ms;
  double peak_memory_mb = 0.0;

  std::optional<LoopLines> loops;  ///< Nothing where the run looked for none.

  std::vector<StripFrame> strip;

  std::vector<std::pair<std::string, std::string>> options;  ///< Name and value.
  std::vector<WeightsLine> weights;
  std::string version;    ///< Of gluevo.
  std::string processor;  ///< Its name, as the system gives it.
  std::string isa;
  int threads = 1;
};

/// Writes the report as one HTML file that needs no other and asks for none: no script, style and
/// pictures inside. Beside its place first, then renamed. Throws Error where it cannot be written.
void WriteRunReport(const std::filesystem::path& path, const RunReport& report);

}  // namespace gluevo::apps
