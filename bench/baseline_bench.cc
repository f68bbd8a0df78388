// What the baseline costs a frame on one thread, beside OpenCV's own functions called the way that
// VINS-Fusion calls them: goodFeaturesToTrack, and calcOpticalFlowPyrLK forth and back, from frame
// to frame and from left to right. Processor time, so that other programs disturb it little.
//   gluevo_baseline_bench DATASET [CORNERS] [ROUNDS]

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <exception>
#include <iostream>
#include <memory>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <string>
#include <utility>
#include <vector>

#include "gluevo/vo/frontend/klt_frontend.h"
#include "gluevo/vo/io/dataset.h"
#include "gluevo/vo/pipeline/odometry.h"

namespace gluevo::vo {
namespace {

double ProcessorMs() {
  timespec time = {};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

// The calls, and no more of a front end than they need for the same work: as many points.
class PlainCalls {
 public:
  explicit PlainCalls(const KltOptions& options) : options_(options) {}

  void Process(const StereoFrame& frame) {
    const cv::Mat& left = frame.images[0];
    if (!points_.empty()) {
      points_ = FollowForthAndBack(last_left_, left);
    }
    cv::Mat mask(left.size(), CV_8UC1, cv::Scalar(255));
    for (const cv::Point2f& point : points_) {
      cv::circle(mask, point, options_.min_distance, cv::Scalar(0), cv::FILLED);
    }
    const int missing = options_.max_corners - static_cast<int>(points_.size());
    if (missing > 0) {
      std::vector<cv::Point2f> corners;
      cv::goodFeaturesToTrack(left, corners, missing, options_.quality, options_.min_distance,
                              mask);
      points_.insert(points_.end(), corners.begin(), corners.end());
    }
    FollowForthAndBack(left, frame.images[1]);
    last_left_ = left;
  }

 private:
  std::vector<cv::Point2f> FollowForthAndBack(const cv::Mat& from, const cv::Mat& to) const {
    const cv::Size window(options_.window, options_.window);
    std::vector<cv::Point2f> there;
    std::vector<unsigned char> found;
    std::vector<unsigned char> returns;
    std::vector<float> errors;
    cv::calcOpticalFlowPyrLK(from, to, points_, there, found, errors, window, options_.levels);
    std::vector<cv::Point2f> back = points_;
    cv::calcOpticalFlowPyrLK(to, from, there, back, returns, errors, window, 1,
                             {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 30, 0.01},
                             cv::OPTFLOW_USE_INITIAL_FLOW);
    const cv::Rect2f inside(1.0F, 1.0F, static_cast<float>(to.cols - 2),
                            static_cast<float>(to.rows - 2));
    std::vector<cv::Point2f> kept;
    for (std::size_t i = 0; i < there.size(); ++i) {
      if (found[i] != 0 && returns[i] != 0 && inside.contains(there[i]) &&
          cv::norm(back[i] - points_[i]) <= options_.max_return_distance) {
        kept.push_back(there[i]);
      }
    }
    return kept;
  }

  KltOptions options_;
  cv::Mat last_left_;
  std::vector<cv::Point2f> points_;
};

// Passes a front end's work on and notes its processor time.
class TimedFrontEnd final : public FrontEnd {
 public:
  TimedFrontEnd(std::unique_ptr<FrontEnd> frontend, double* ms)
      : frontend_(std::move(frontend)), ms_(ms) {}
  TrackedFrame Track(const StereoFrame& frame) override {
    const double start = ProcessorMs();
    TrackedFrame tracked = frontend_->Track(frame);
    *ms_ = ProcessorMs() - start;
    return tracked;
  }

 private:
  std::unique_ptr<FrontEnd> frontend_;
  double* ms_;
};

double Median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

void Compare(const Dataset& dataset, int corners, int rounds) {
  KltOptions klt;
  klt.max_corners = corners;
  OdometryOptions odometry_options;
  odometry_options.window.keyframe_parallax_px = 15.0;
  std::vector<double> calls, frontend, estimator;
  for (int round = 0; round < rounds; ++round) {
    PlainCalls plain(klt);
    double frontend_ms = 0.0;
    Odometry odometry(dataset.rig,
                      std::make_unique<TimedFrontEnd>(
                          std::make_unique<KltFrontEnd>(dataset.rig, klt), &frontend_ms),
                      odometry_options);
    for (std::size_t i = 0; i < dataset.entries.size(); ++i) {
      const StereoFrame frame = dataset.Read(i);
      const double start = ProcessorMs();
      plain.Process(frame);
      const double middle = ProcessorMs();
      odometry.Process(frame);
      const double end = ProcessorMs();
      calls.push_back(middle - start);
      frontend.push_back(frontend_ms);
      estimator.push_back(end - middle - frontend_ms);
    }
  }
  const double yardstick = Median(calls);
  const auto print = [&](const char* name, double ms) {
    std::cout << name << ms << " ms, " << ms / yardstick << " of OpenCV's calls\n";
  };
  std::cout << "median of " << calls.size() << " frames, " << corners << " corners, one thread\n";
  print("OpenCV's calls  ", yardstick);
  print("front end klt   ", Median(frontend));
  print("estimator       ", Median(estimator));
}

}  // namespace
}  // namespace gluevo::vo

int main(int argc, char** argv) {
  if (argc < 2) {
    std::cerr << "usage: gluevo_baseline_bench DATASET [CORNERS] [ROUNDS]\n";
    return 2;
  }
  try {
    cv::setNumThreads(1);
    gluevo::vo::Compare(gluevo::vo::OpenDataset(argv[1], {}), argc > 2 ? std::atoi(argv[2]) : 200,
                        argc > 3 ? std::atoi(argv[3]) : 5);
  } catch (const std::exception& error) {
    std::cerr << "gluevo_baseline_bench: " << error.what() << "\n";
    return 1;
  }
}
