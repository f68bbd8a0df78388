#include "localization_table.h"

#include <algorithm>
#include <iomanip>
#include <ostream>
#include <sstream>

#include "gluevo/nn/error.h"
#include "gluevo/nn/output_file.h"
#include "gluevo/nn/replaced_file.h"
#include "gluevo/vo/core/angle.h"
#include "gluevo/vo/core/text.h"
#include "gluevo/vo/evaluation/evaluation.h"
#include "gluevo/vo/io/trajectory_file.h"

namespace gluevo::apps {
namespace {

constexpr const char* kTableMark = "# frames in a map";
constexpr const char* kTrajectoryMark = "in the frame of a map";

// As spreadsheets read it.
std::string Field(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) {
    return text;
  }
  std::string field = "\"";
  for (const char c : text) {
    field += c == '"' ? "\"\"" : std::string(1, c);
  }
  return field + "\"";
}

bool IsFound(const LocalizedFrame& frame) { return frame.result && frame.result->is_found; }

vo::Trajectory PosesInPart(const std::vector<LocalizedFrame>& frames, int part) {
  vo::Trajectory poses;
  for (const LocalizedFrame& frame : frames) {
    if (IsFound(frame) && frame.result->part == part) {
      poses.push_back({frame.timestamp_ns, frame.result->map_from_body});
    }
  }
  std::stable_sort(poses.begin(), poses.end(),
                   [](const auto& a, const auto& b) { return a.timestamp_ns < b.timestamp_ns; });
  return poses;
}

void WriteRow(std::ostream& out, const LocalizedFrame& frame, const vo::PlaceMap& map) {
  out << Field(frame.name) << ',' << frame.timestamp_ns << ',';
  if (!frame.result) {
    out << "left out,,,,,,,,,,,,,,,,\n";
    return;
  }
  const vo::Localization& result = *frame.result;
  if (result.is_found) {
    const vo::Rigid3& pose = result.map_from_body;
    out << "found," << result.part;
    for (const double value : pose.translation) {
      out << ',' << value;
    }
    for (const double value : pose.rotation.coeffs()) {
      out << ',' << value;
    }
    out << ',' << result.position_sigma_m << ',' << result.rotation_sigma_rad / vo::kDegree;
  } else {
    out << "not found,,,,,,,,,,";
  }
  out << ',' << result.matches << ',' << result.inliers << ',' << result.inlier_share << ',';
  if (!map.keyframes.empty()) {
    out << map.keyframes[result.keyframe].timestamp_ns;
  }
  out << ',' << result.similarity << ',' << Field(result.reason) << '\n';
}

}  // namespace

LocalizationPlaces PlacesIn(const std::filesystem::path& folder) {
  return {folder / "trajectory.tum", folder / "localization.csv"};
}

void CheckReplacesOnlyLocalization(const LocalizationPlaces& places) {
  nn::CheckReplacesOnly(places.trajectory, kTrajectoryMark, "a trajectory of gluevo localize");
  nn::CheckReplacesOnly(places.table, kTableMark, "a table of gluevo localize");
}

void WriteLocalization(const LocalizationPlaces& places, const std::vector<LocalizedFrame>& frames,
                       const vo::PlaceMap& map) {
  vo::WriteTrajectory(
      places.trajectory, PosesInPart(frames, map.LargestPart()), vo::TrajectoryFormat::kTum,
      "pose of the " + map.rig.body_frame + " " + kTrajectoryMark + "'s largest part");
  nn::WriteWholeFile(places.table, [&](std::ostream& out) {
    constexpr int kDigits = 9;
    out << std::setprecision(kDigits) << kTableMark << ": poses of the " << map.rig.body_frame
        << " in the frame of the map's part, metres; what is left empty is not known\n"
           "#image,timestamp_ns,status,part,x,y,z,qx,qy,qz,qw,position_sigma_m,rotation_sigma_deg,"
           "matches,inliers,inlier_share,keyframe_ns,similarity,reason\n";
    for (const LocalizedFrame& frame : frames) {
      WriteRow(out, frame, map);
    }
  });
}

std::string SummaryOf(const std::vector<LocalizedFrame>& frames, const vo::PlaceMap& map,
                      const std::optional<vo::Trajectory>& groundtruth) {
  const auto found = std::count_if(frames.begin(), frames.end(), IsFound);
  const vo::Trajectory poses = PosesInPart(frames, map.LargestPart());
  std::ostringstream text;
  text << "found: " << found << " of " << vo::Counted(frames.size(), "frame");
  if (poses.size() != static_cast<std::size_t>(found)) {
    text << ", " << poses.size() << " of them in the map's largest part";
  }
  if (groundtruth) {
    try {
      const vo::Evaluation evaluation = vo::Evaluate(poses, *groundtruth, {});
      text << "; ATE " << std::fixed << std::setprecision(4) << evaluation.ate_se3_m << " m (SE3)";
    } catch (const Error& error) {
      text << "; no error: " << error.what();
    }
  }
  text << '\n';
  return text.str();
}

}  // namespace gluevo::apps
