#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "frame_source.h"
#include "gluevo/vo/pipeline/live_pipeline.h"
#include "gluevo/vo/pipeline/loop_thread.h"
#include "live_record.h"
#include "pose_publisher.h"
#include "run_frames.h"
#include "view/view_feed.h"

namespace gluevo::apps {

/// What takes part while `gluevo live` runs. All must outlive it.
struct LiveParts {
  LiveSource& source;
  RunRecords& records;
  std::vector<std::unique_ptr<LinePublisher>> publishers;
  bool prints_poses = true;          ///< On standard output, too.
  std::optional<double> duration_s;  ///< Ends then, by the source's clock.
  std::unique_ptr<ViewFeed> view;    ///< Null: nobody looks.
  /// For its button, on the tracking thread, which waits: saves the map as it is, and gives what to
  /// tell of it.
  std::function<std::string()> save_map;
};

/// How it ended.
struct LiveEnd {
  EarlyEnd end;
  bool is_whole = false;  ///< The source has no more.
};

/// Takes what the source gives through the odometry until it ends, a signal comes or time is up.
/// The records' metrics have to keep frames on disk; afterwards all is in the records.
class LiveRun {
 public:
  LiveRun(LiveParts parts, vo::Odometry odometry, const vo::LiveOptions& options);
  LiveRun(const LiveRun&) = delete;
  LiveRun& operator=(const LiveRun&) = delete;

  LiveEnd Run();

  const vo::Odometry& odometry() const { return pipeline_->odometry(); }
  const LiveRecord& record() const { return record_; }

 private:
  struct LeftOut {
    std::size_t frame = 0;
    std::string why;
  };

  void Tracked(const vo::StereoFrame& frame, vo::FrameResult& result, const vo::Odometry& odometry);
  void Publish(const vo::LiveResult& live);
  void ShowTracked(const vo::FrameResult& result, const vo::Odometry& odometry);
  /// False at the end.
  bool Take(SourceEvent event);
  void GatherRecords();
  void TellStatus(int64_t since_begin_ns);

  LiveParts parts_;
  std::vector<LeftOut> left_out_;
  int64_t next_status_ns_ = 0;
  std::optional<vo::LoopThread> loop_thread_;
  std::size_t loops_ = 0;          // That were closed so far.
  std::atomic<int64_t> late_ = 0;  // Frames that the source passed over.
  LiveRecord record_;
  std::unique_ptr<vo::LivePipeline> pipeline_;  // Last: its threads use the others.
};

}  // namespace gluevo::apps
