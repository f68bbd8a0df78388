#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

#include "gluevo/nn/thread_pool.h"
#include "gluevo/vo/core/frame_result.h"
#include "gluevo/vo/core/stereo_frame.h"
#include "gluevo/vo/frontend/network_memo.h"
#include "gluevo/vo/geometry/stereo_rig.h"
#include "gluevo/vo/mapping/loop_recorder.h"

namespace gluevo::vo {

/// What the front end has found in a frame that loops may keep; nothing without a memo.
KnownFeatures FeaturesKnownOf(const ExtractorMemo* memo, const StereoFrame& frame,
                              const FrameResult& result);

/// Threads for networks that run beside tracking: where processors are few these have what tracking
/// leaves. As nn::ThreadPool otherwise.
std::unique_ptr<nn::ThreadPool> MakeBackgroundPool(int threads);

struct LoopThreadOptions {
  /// So many frames wait at most with their images.
  std::size_t max_frames = 32;
  /// Where more come: whether the caller waits, or the newest is taken without its images, so that
  /// it is no place to come back to. Waiting gives the same loops each time.
  bool waits = true;
};

/// A LoopRecorder beside tracking: on a thread of its own that has the processors after all others.
/// Frames are taken in order, so that its loops are those of LoopRecorder::Add after each frame.
class LoopThread {
 public:
  /// `recorder` must outlive it, its networks use MakeBackgroundPool's threads, and nobody else
  /// may use it until Finish(), but by Look. `memo`: the front end's, or null.
  LoopThread(LoopRecorder& recorder, std::shared_ptr<const ExtractorMemo> memo,
             const LoopThreadOptions& options = {});
  /// As Finish(), but silent.
  ~LoopThread();
  LoopThread(const LoopThread&) = delete;
  LoopThread& operator=(const LoopThread&) = delete;

  /// To be called after every frame, by one thread. False where the recorder has thrown: nothing
  /// is taken any more. The images' memory must not be written any more.
  bool Add(const StereoFrame& frame, const FrameResult& result, const StereoRig& rig);

  /// Shows the recorder as it is between two frames, some of the newest not yet among them. Waits
  /// for the frame at work.
  void Look(const std::function<void(const LoopRecorder&)>& look) const;
  /// How many loops are closed so far. Never waits.
  std::size_t loops() const;

  /// What waits is taken without its images: for a run that is to end at once.
  void PassOverWaiting();

  /// Waits until all frames are done. Returns what each has taken, milliseconds. Throws what the
  /// recorder threw.
  std::vector<double> Finish();

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace gluevo::vo
