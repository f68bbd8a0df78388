#include "run_frames.h"

#include <array>
#include <exception>
#include <filesystem>

#include "command_line/message.h"
#include "gluevo/nn/error.h"
#include "gluevo/vo/core/stopwatch.h"
#include "interruption.h"
#include "progress.h"

namespace gluevo::apps {
namespace {

// As COLMAP finds the images when it is told the data set's folder.
std::array<std::string, 2> ImageNames(const vo::Dataset& dataset, std::size_t index) {
  const auto name = [&](const std::filesystem::path& path) {
    return path.lexically_proximate(dataset.root).generic_string();
  };
  const auto& images = dataset.entries[index].images;
  return {name(images[0]), name(images[1])};
}

// Says that a frame is left out, unless so many are that nobody would read it.
void Tell(const std::string& why, std::size_t left_out) {
  constexpr std::size_t kMostTold = 10;
  if (left_out <= kMostTold) {
    PrintMessage("gluevo: warning", "frame left out: " + why);
  }
  if (left_out == kMostTold) {
    PrintMessage("gluevo: warning", "more frames that are left out are named in metrics.json only");
  }
}

// Nothing where the frame cannot be read.
std::optional<vo::StereoFrame> ReadFrame(const FrameSource& source, std::size_t index,
                                         RunRecords& records) {
  const int64_t timestamp_ns = source.dataset.entries[index].timestamp_ns;
  if (!source.reads_images) {
    return vo::StereoFrame{timestamp_ns, {}};
  }
  try {
    return source.dataset.Read(index);
  } catch (const Error& error) {
    if (source.is_strict) {
      throw;
    }
    records.metrics.FrameIsLeftOut(index, error.what());
    if (records.matches) {
      records.matches->LeaveOut(timestamp_ns);
    }
    Tell(error.what(), records.metrics.left_out());
    return std::nullopt;
  }
}

// The number of inliers and the segment, for the progress.
std::string ProcessFrame(const FrameSource& source, std::size_t index, vo::Odometry& odometry,
                         RunRecords& records) {
  records.metrics.StartFrame();
  const std::optional<vo::StereoFrame> frame = ReadFrame(source, index, records);
  if (!frame) {
    return "left out";
  }
  records.metrics.FrameIsRead();
  vo::FrameResult result = odometry.Process(*frame);
  if (records.loops) {
    vo::StageTimer timer(result.stages_ms);
    records.loops->Add(*frame, result, odometry.rig());
    timer.End("loops");
  }
  records.metrics.FrameIsDone(result);
  records.trajectory.push_back({result.timestamp_ns, result.world_from_body});
  if (result.is_keyframe) {
    records.keyframes.push_back(records.trajectory.back());
  }
  records.diagnosis.Add(*frame, result);
  if (records.matches) {
    records.matches->Add(result.tracked_frame);
  }
  if (source.reads_images) {
    records.strip.Add(result, [&] { return *frame; });
  }
  if (records.map) {
    records.map->Add(*frame, ImageNames(source.dataset, index), result, odometry.rig(),
                     odometry.MapPoints());
  }
  return std::to_string(result.inliers) + " inliers, segment " + std::to_string(result.segment);
}

}  // namespace

void CheckNamesForMap(const vo::Dataset& dataset) {
  for (std::size_t i = 0; i < dataset.entries.size(); ++i) {
    vo::CheckImageNames(ImageNames(dataset, i));
  }
}

EarlyEnd ProcessFrames(const FrameSource& source, vo::Odometry& odometry, RunRecords& records) {
  const std::size_t count = source.dataset.entries.size();
  Progress progress("frame", count);
  for (std::size_t i = 0; i < count; ++i) {
    try {
      progress.Update(i + 1, ProcessFrame(source, i, odometry, records));
    } catch (const std::exception& error) {  // What is done is not lost, whatever fails.
      return {error.what(), 0};
    }
    if (const int signal = Interruption::signal(); signal != 0 && i + 1 < count) {
      return {"", signal};
    }
  }
  return {};
}

}  // namespace gluevo::apps
