#include "gluevo/vo/frontend/match_store.h"

#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

#include "gluevo/nn/error.h"
#include "gluevo/vo/io/hdf5_file.h"
#include "match_store_layout.h"

namespace gluevo::vo {

MatchStoreWriter::MatchStoreWriter(const std::filesystem::path& path, const StereoRig& rig,
                                   const RunRecord& record)
    : file_(internal::CreateH5(path)) {
  file_->WriteTexts("/", {{"format", match_store::kFormat},
                          {"version", match_store::kVersion},
                          {"method", record.method}});
  file_->MakeGroup("options", "");
  file_->WriteTexts("options", record.options);
  file_->MakeGroup("weights", "");
  file_->WriteTexts("weights", record.weights);
  std::vector<double> rows;
  for (int i = 0; i < 2; ++i) {
    const auto row = match_store::RigRow(rig.cameras[i], rig.body_from_cam[i]);
    rows.insert(rows.end(), row.begin(), row.end());
  }
  file_->Write("rig", {2, match_store::kRigColumns}, rows.data());
  file_->MakeGroup("frames", "");
}

void MatchStoreWriter::Add(const TrackedFrame& frame) {
  const Eigen::Vector2d none = Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
  std::vector<int64_t> track_ids;
  std::vector<double> left_pixels, previous_left_pixels, right_pixels, left, right;
  std::vector<float> tracking_confidences, stereo_confidences;
  std::unordered_map<int64_t, Eigen::Vector2d> left_of_track;
  const auto push = [](std::vector<double>& values, const Eigen::Vector2d& point) {
    values.insert(values.end(), {point.x(), point.y()});
  };
  for (const Observation& observation : frame.observations) {
    track_ids.push_back(observation.track_id);
    left_of_track[observation.track_id] = observation.left_pixel;
    const auto before = previous_left_.find(observation.track_id);
    push(left_pixels, observation.left_pixel);
    push(previous_left_pixels, before != previous_left_.end() ? before->second : none);
    push(right_pixels, observation.has_right ? observation.right_pixel : none);
    push(left, observation.left);
    push(right, observation.has_right ? observation.right : none);
    tracking_confidences.push_back(observation.tracking_confidence);
    stereo_confidences.push_back(observation.stereo_confidence);
  }
  const hsize_t count = track_ids.size();
  const std::string group = match_store::FrameGroup(timestamps_ns_.size());
  file_->MakeGroup(group, "track_ids");
  file_->Write(group + "/track_ids", {count}, track_ids.data());
  file_->Write(group + "/left_pixels", {count, 2}, left_pixels.data());
  file_->Write(group + "/previous_left_pixels", {count, 2}, previous_left_pixels.data());
  file_->Write(group + "/right_pixels", {count, 2}, right_pixels.data());
  file_->Write(group + "/left", {count, 2}, left.data());
  file_->Write(group + "/right", {count, 2}, right.data());
  file_->Write(group + "/tracking_confidences", {count}, tracking_confidences.data());
  file_->Write(group + "/stereo_confidences", {count}, stereo_confidences.data());
  timestamps_ns_.push_back(frame.timestamp_ns);
  previous_left_ = std::move(left_of_track);
}

void MatchStoreWriter::Finish() {
  file_->Write("timestamps_ns", {timestamps_ns_.size()}, timestamps_ns_.data());
  if (!left_out_ns_.empty()) {
    file_->Write("left_out_ns", {left_out_ns_.size()}, left_out_ns_.data());
  }
  file_->Finish();
}

}  // namespace gluevo::vo
