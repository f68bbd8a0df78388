#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <utility>

#include "gluevo/nn/error.h"
#include "gluevo/vo/frontend/match_store.h"
#include "gluevo/vo/io/hdf5_file.h"
#include "match_store_layout.h"

namespace gluevo::vo {
namespace {

constexpr int64_t kMostFrames = int64_t{1} << 26;
constexpr int64_t kMostObservations = int64_t{1} << 20;

std::string TextOf(const std::map<std::string, std::string>& texts, const std::string& name) {
  const auto found = texts.find(name);
  return found != texts.end() ? found->second : "";
}

std::vector<Eigen::Vector2d> ReadPoints(const internal::H5InputFile& file,
                                        const std::string& dataset, int64_t count) {
  const std::vector<int64_t> shape = file.ShapeOf(dataset, 2, kMostObservations);
  if (shape[0] != count || shape[1] != 2) {
    throw Error(file.Place(dataset) + " has shape [" + std::to_string(shape[0]) + " x " +
                std::to_string(shape[1]) + "], expected [" + std::to_string(count) + " x 2]");
  }
  const std::vector<double> values = file.ReadDoubles(dataset);
  std::vector<Eigen::Vector2d> points;
  for (std::size_t i = 0; i + 1 < values.size(); i += 2) {
    points.emplace_back(values[i], values[i + 1]);
  }
  return points;
}

std::vector<float> ReadConfidences(const internal::H5InputFile& file, const std::string& dataset,
                                   int64_t count) {
  if (file.ShapeOf(dataset, 1, kMostObservations)[0] != count) {
    throw Error(file.Place(dataset) + " is not of as many values as there are tracks, " +
                std::to_string(count));
  }
  return file.ReadFloats(dataset);
}

/// What differs between the rig that a store was made with and the data set's; empty for nothing.
std::string DifferenceOf(const StereoRig& stored, const StereoRig& rig) {
  for (int i = 0; i < 2; ++i) {
    const Camera& a = stored.cameras[i];
    const Camera& b = rig.cameras[i];
    const std::string camera = "camera " + std::to_string(i);
    if (a.width != b.width || a.height != b.height) {
      return camera + " has " + std::to_string(a.width) + " x " + std::to_string(a.height) +
             " pixels there and " + std::to_string(b.width) + " x " + std::to_string(b.height) +
             " in the data set";
    }
    if (match_store::RigRow(a, stored.body_from_cam[i]) !=
        match_store::RigRow(b, rig.body_from_cam[i])) {
      return camera + " is calibrated differently in the data set";
    }
  }
  return "";
}

}  // namespace

MatchStoreReader::MatchStoreReader(const std::filesystem::path& path)
    : path_(path), file_(internal::OpenH5(path)) {
  const std::map<std::string, std::string> about = file_->ReadTexts("/");
  if (TextOf(about, "format") != match_store::kFormat) {
    throw Error(path.string() + ": holds no matches of a run, expected a file of --save-matches");
  }
  const std::string version = TextOf(about, "version");
  if (version != match_store::kVersion && version != match_store::kVersionOfFive) {
    throw Error(path.string() + ": matches in version " + Quoted(version) +
                " of their format, expected version " + match_store::kVersion);
  }
  record_ = {TextOf(about, "method"), file_->ReadTexts("options"), file_->ReadTexts("weights")};
  rig_ = ReadRig(version == match_store::kVersion ? match_store::kRigColumns
                                                  : match_store::kRigColumnsOfFive);
  file_->ShapeOf("timestamps_ns", 1, kMostFrames);
  timestamps_ns_ = file_->ReadLongIntegers("timestamps_ns");
  if (file_->Has("left_out_ns")) {
    file_->ShapeOf("left_out_ns", 1, kMostFrames);
    left_out_ns_ = file_->ReadLongIntegers("left_out_ns");
  }
}

StereoRig MatchStoreReader::ReadRig(std::size_t columns) const {
  const std::vector<int64_t> shape = file_->ShapeOf("rig", 2, match_store::kRigColumns);
  const std::vector<double> values = file_->ReadDoubles("rig");
  if (shape[0] != 2 || shape[1] != static_cast<int64_t>(columns) ||
      !std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); })) {
    throw Error(file_->Place("rig") + " is malformed, expected 2 x " + std::to_string(columns) +
                " finite values");
  }
  StereoRig rig;
  for (int i = 0; i < 2; ++i) {
    const double* const row = values.data() + i * columns;
    Camera& camera = rig.cameras[i];
    const double largest = 1 << 20;
    if (!(row[0] >= 1 && row[0] <= largest && row[1] >= 1 && row[1] <= largest && row[6] >= 0 &&
          row[6] <= static_cast<double>(Distortion::kFieldOfView))) {
      throw Error(file_->Place("rig") + " is malformed: no size or no distortion of camera " +
                  std::to_string(i));
    }
    camera = {static_cast<int>(row[0]), static_cast<int>(row[1]), row[2], row[3], row[4], row[5]};
    camera.distortion = static_cast<Distortion>(static_cast<int>(row[6]));
    const double* const pose = row + columns - match_store::kPoseColumns;
    std::copy(row + match_store::kFirstCoefficient, pose, camera.coefficients.begin());
    rig.body_from_cam[i].rotation.coeffs() = Eigen::Vector4d(pose[0], pose[1], pose[2], pose[3]);
    rig.body_from_cam[i].translation = Eigen::Vector3d(pose[4], pose[5], pose[6]);
  }
  return rig;
}

TrackedFrame MatchStoreReader::Read(std::size_t index) const {
  const std::string group = match_store::FrameGroup(index);
  const std::string track_ids = group + "/track_ids";
  const int64_t count = file_->ShapeOf(track_ids, 1, kMostObservations)[0];
  const std::vector<int64_t> ids = file_->ReadLongIntegers(track_ids);
  const auto points = [&](const char* name) {
    return ReadPoints(*file_, group + "/" + name, count);
  };
  const std::vector<Eigen::Vector2d> left_pixels = points("left_pixels");
  const std::vector<Eigen::Vector2d> right_pixels = points("right_pixels");
  const std::vector<Eigen::Vector2d> left = points("left");
  const std::vector<Eigen::Vector2d> right = points("right");
  const std::vector<float> tracking =
      ReadConfidences(*file_, group + "/tracking_confidences", count);
  const std::vector<float> stereo = ReadConfidences(*file_, group + "/stereo_confidences", count);

  TrackedFrame frame;
  frame.timestamp_ns = timestamps_ns_.at(index);
  std::set<int64_t> seen;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (!seen.insert(ids[i]).second) {
      throw Error(file_->Place(track_ids) + " names track " + std::to_string(ids[i]) + " twice");
    }
    if (!left_pixels[i].allFinite() || !left[i].allFinite()) {
      throw Error(file_->Place(group) + " has a left point that is not finite at position " +
                  std::to_string(i));
    }
    Observation observation{.track_id = ids[i], .left_pixel = left_pixels[i], .left = left[i]};
    observation.tracking_confidence = tracking[i];
    observation.stereo_confidence = stereo[i];
    observation.has_right = right_pixels[i].allFinite() && right[i].allFinite();
    if (observation.has_right) {
      observation.right_pixel = right_pixels[i];
      observation.right = right[i];
    }
    frame.observations.push_back(observation);
  }
  return frame;
}

ReplayFrontEnd::ReplayFrontEnd(MatchStoreReader store, const StereoRig& rig,
                               const std::vector<int64_t>& timestamps_ns)
    : store_(std::move(store)) {
  const std::string place = store_.path().string() + ": matches of other data: ";
  if (const std::string difference = DifferenceOf(store_.rig(), rig); !difference.empty()) {
    throw Error(place + difference);
  }
  const std::vector<int64_t>& stored = store_.timestamps_ns();
  if (timestamps_ns.size() > stored.size()) {
    throw Error(place + std::to_string(stored.size()) + " frames there, " +
                std::to_string(timestamps_ns.size()) + " in the data set");
  }
  const auto [other, at] =
      std::mismatch(timestamps_ns.begin(), timestamps_ns.end(), stored.begin());
  if (other != timestamps_ns.end()) {
    throw Error(place + "frame " + std::to_string(other - timestamps_ns.begin()) + " is at " +
                std::to_string(*at) + " ns there and at " + std::to_string(*other) +
                " ns in the data set (another --start or --stride?)");
  }
}

TrackedFrame ReplayFrontEnd::Track(const StereoFrame& frame) {
  if (next_ >= store_.timestamps_ns().size() ||
      store_.timestamps_ns()[next_] != frame.timestamp_ns) {
    throw Error(store_.path().string() + ": no matches of the frame at " +
                std::to_string(frame.timestamp_ns) + " ns, expected those of frame " +
                std::to_string(next_));
  }
  return store_.Read(next_++);
}

}  // namespace gluevo::vo
