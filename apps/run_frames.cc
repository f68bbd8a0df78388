#include "run_frames.h"

#include <array>
#include <exception>
#include <filesystem>
#include <functional>
#include <thread>
#include <utility>
#include <vector>

#include "command_line/message.h"
#include "gluevo/nn/error.h"
#include "gluevo/vo/core/bounded_queue.h"
#include "gluevo/vo/core/stopwatch.h"
#include "gluevo/vo/pipeline/loop_thread.h"
#include "interruption.h"
#include "progress.h"

namespace gluevo::apps {
namespace {

constexpr std::size_t kFramesThatWait = 2;  // So that a slow image holds nobody up.

// From the reader to the odometry.
struct ReadFrame {
  std::size_t index = 0;
  std::optional<vo::StereoFrame> frame;  // Nothing where it cannot be read.
  std::string why_left_out;
  std::exception_ptr failure;  // What ends the run here.
  double read_ms = 0.0;
};

// From the odometry to what is made of it.
struct TrackedPair {
  std::size_t index = 0;
  int64_t timestamp_ns = 0;
  std::optional<vo::StereoFrame> frame;  // Nothing where it was left out, as the next three.
  vo::FrameResult result;
  std::optional<vo::StereoRig> rig;
  std::vector<vo::MapPoint> map_points;
};

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

ReadFrame Read(const FrameSource& source, std::size_t index) {
  vo::Stopwatch watch;
  ReadFrame read{.index = index};
  try {
    read.frame = source.reads_images
                     ? source.dataset.Read(index)
                     : vo::StereoFrame{source.dataset.entries[index].timestamp_ns, {}};
  } catch (const Error& error) {
    read.why_left_out = error.what();
    read.failure = source.is_strict ? std::current_exception() : nullptr;
  } catch (const std::exception&) {
    read.failure = std::current_exception();
  }
  read.read_ms = watch.Lap();
  return read;
}

// One after the other: the front end has to know what became of the frame before.
TrackedPair Track(const FrameSource& source, ReadFrame read, vo::Odometry& odometry,
                  RunRecords& records) {
  if (read.failure) {
    std::rethrow_exception(read.failure);
  }
  TrackedPair pair{.index = read.index,
                   .timestamp_ns = source.dataset.entries[read.index].timestamp_ns};
  if (!read.frame) {
    records.metrics.FrameIsLeftOut(read.index, read.why_left_out);
    Tell(read.why_left_out, records.metrics.left_out());
    return pair;
  }
  records.metrics.FrameIsRead(read.read_ms);
  pair.frame = std::move(read.frame);
  pair.result = odometry.Process(*pair.frame);
  vo::FrameResult& result = pair.result;
  if (records.loops && !source.overlaps) {
    vo::StageTimer timer(result.stages_ms);
    records.loops->Add(*pair.frame, result, odometry.rig(),
                       vo::FeaturesKnownOf(records.extracted.get(), *pair.frame, result));
    timer.End("loops");
  }
  records.metrics.FrameIsDone(result);
  records.trajectory.push_back({result.timestamp_ns, result.world_from_body});
  if (result.is_keyframe) {
    records.keyframes.push_back(records.trajectory.back());
  }
  pair.rig = odometry.rig();
  if (records.map) {
    pair.map_points = odometry.MapPoints();
  }
  return pair;
}

void Record(const FrameSource& source, const TrackedPair& pair, RunRecords& records) {
  if (!pair.frame) {
    if (records.matches) {
      records.matches->LeaveOut(pair.timestamp_ns);
    }
    return;
  }
  records.diagnosis.Add(*pair.frame, pair.result);
  if (records.matches) {
    records.matches->Add(pair.result.tracked_frame);
  }
  if (source.reads_images) {
    records.strip.Add(pair.result, [&] { return *pair.frame; });
  }
  if (records.map) {
    records.map->Add(*pair.frame, ImageNames(source.dataset, pair.index), pair.result, *pair.rig,
                     pair.map_points);
  }
}

// For the progress.
std::string Note(const TrackedPair& pair) {
  return pair.frame ? std::to_string(pair.result.inliers) + " inliers, segment " +
                          std::to_string(pair.result.segment)
                    : "left out";
}

// Where a frame comes from and goes to; `give` is false where nothing more is taken.
struct Neighbours {
  std::function<std::optional<ReadFrame>()> next;
  /// The frame after it, where it is there by now.
  std::function<std::optional<ReadFrame>()> look_ahead;
  std::function<bool(TrackedPair)> give;
};

EarlyEnd TrackAll(const FrameSource& source, const Neighbours& neighbours, vo::Odometry& odometry,
                  RunRecords& records) {
  const std::size_t count = source.dataset.entries.size();
  Progress progress("frame", count);
  try {
    std::optional<ReadFrame> after;
    while (std::optional<ReadFrame> read =
               after ? std::exchange(after, std::nullopt) : neighbours.next()) {
      if (read->frame && (after = neighbours.look_ahead()) && after->frame) {
        odometry.Announce(*after->frame);
      }
      TrackedPair pair = Track(source, *std::move(read), odometry, records);
      const std::size_t done = pair.index + 1;
      progress.Update(done, Note(pair));
      if (!neighbours.give(std::move(pair))) {
        return {};
      }
      if (const int signal = Interruption::signal(); signal != 0 && done < count) {
        return {"", signal};
      }
    }
  } catch (const std::exception& error) {  // What is done is not lost, whatever fails.
    return {error.what(), 0};
  }
  return {};
}

EarlyEnd ProcessInTurn(const FrameSource& source, vo::Odometry& odometry, RunRecords& records) {
  std::size_t index = 0;
  const auto next = [&]() -> std::optional<ReadFrame> {
    if (index == source.dataset.entries.size()) {
      return std::nullopt;
    }
    return Read(source, index++);
  };
  const auto give = [&](const TrackedPair& pair) {
    Record(source, pair, records);
    return true;
  };
  return TrackAll(source, {next, [] { return std::nullopt; }, give}, odometry, records);
}

// What is made of tracked frames beside tracking: all but loops on a thread, these on another.
class Recording {
 public:
  Recording(const FrameSource& source, RunRecords& records)
      : source_(source), records_(records), thread_([this] {
          try {
            while (const std::optional<TrackedPair> pair = queue_.Pop()) {
              Record(source_, *pair, records_);
            }
          } catch (const std::exception& error) {
            failure_ = error.what();
            queue_.Close();
          }
        }) {
    if (records.loops) {
      loops_.emplace(*records.loops, records.extracted);
    }
  }

  bool Take(TrackedPair pair) {
    const bool has_failed =
        loops_ && pair.frame && !loops_->Add(*pair.frame, pair.result, *pair.rig);
    return !has_failed && queue_.Push(std::move(pair));
  }

  /// Waits until all is done, loops apart where it is `urgent`. Returns what could not be, or
  /// nothing.
  std::string Finish(bool urgent) {
    queue_.Close();
    thread_.join();
    if (loops_ && urgent) {
      loops_->PassOverWaiting();
    }
    if (loops_) {
      try {
        records_.metrics.AddStage("loops", loops_->Finish());
      } catch (const std::exception& error) {
        failure_ = failure_.empty() ? error.what() : failure_;
      }
    }
    return failure_;
  }

 private:
  const FrameSource& source_;
  RunRecords& records_;
  vo::BoundedQueue<TrackedPair> queue_{kFramesThatWait};
  std::string failure_;
  std::optional<vo::LoopThread> loops_;
  std::jthread thread_;  // Last: it uses the others.
};

EarlyEnd ProcessOverlapped(const FrameSource& source, vo::Odometry& odometry, RunRecords& records) {
  vo::BoundedQueue<ReadFrame> to_track(kFramesThatWait);
  Recording recording(source, records);
  EarlyEnd end;
  {
    const std::jthread reader([&] {
      for (std::size_t i = 0; i < source.dataset.entries.size(); ++i) {
        if (!to_track.Push(Read(source, i))) {
          return;
        }
      }
      to_track.Close();
    });
    end = TrackAll(source,
                   {[&] { return to_track.Pop(); }, [&] { return to_track.TryPop(); },
                    [&](TrackedPair pair) { return recording.Take(std::move(pair)); }},
                   odometry, records);
    to_track.Close();
  }
  const std::string failure = recording.Finish(end.signal != 0);
  // What could not be recorded came before anything that ended the tracking.
  return failure.empty() ? end : EarlyEnd{failure, 0};
}

}  // namespace

void CheckNamesForMap(const vo::Dataset& dataset) {
  for (std::size_t i = 0; i < dataset.entries.size(); ++i) {
    vo::CheckImageNames(ImageNames(dataset, i));
  }
}

EarlyEnd ProcessFrames(const FrameSource& source, vo::Odometry& odometry, RunRecords& records) {
  records.metrics.Start();
  return source.overlaps ? ProcessOverlapped(source, odometry, records)
                         : ProcessInTurn(source, odometry, records);
}

}  // namespace gluevo::apps
