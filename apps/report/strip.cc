#include "strip.h"

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "chart.h"
#include "gluevo/nn/error.h"
#include "markup.h"

namespace gluevo::apps {
namespace {

constexpr std::size_t kSpread = 8;  // frames, evenly over the run
constexpr std::size_t kMostResets = 4;

// Small, because a report carries a score of them.
std::vector<uint8_t> EncodeJpeg(const cv::Mat& image) {
  constexpr int kMostWidth = 480;
  constexpr int kQuality = 72;
  cv::Mat small = image;
  if (image.cols > kMostWidth) {
    const int height = std::max(1, static_cast<int>(std::lround(static_cast<double>(image.rows) *
                                                                kMostWidth / image.cols)));
    cv::resize(image, small, cv::Size(kMostWidth, height), 0.0, 0.0, cv::INTER_AREA);
  }
  std::vector<uint8_t> bytes;
  if (!cv::imencode(".jpg", small, bytes, {cv::IMWRITE_JPEG_QUALITY, kQuality})) {
    throw Error("an image of the report cannot be encoded as JPEG");
  }
  bytes.shrink_to_fit();  // It is kept as long as the run.
  return bytes;
}

}  // namespace

StripRecorder::StripRecorder(std::size_t frames) : count_(frames) {}

// The middles of as many equal stretches of the run; where its end is not known every so many-th
// frame.
bool StripRecorder::IsChosen() const {
  if (count_ == 0) {
    return index_ % every_ == 0;
  }
  const std::size_t stretches = std::min(kSpread, count_);
  const auto begin = [&](std::size_t stretch) {
    return (stretch * count_ + stretches - 1) / stretches;
  };
  const std::size_t stretch = index_ * stretches / count_;
  return index_ == (begin(stretch) + begin(stretch + 1) - 1) / 2;
}

void StripRecorder::Thin() {
  if (count_ > 0 || frames_.size() - resets_.size() < 2 * kSpread) {
    return;
  }
  every_ *= 2;
  std::erase_if(frames_, [&](const StripFrame& frame) {
    return frame.index % every_ != 0 &&
           std::find(resets_.begin(), resets_.end(), frame.index) == resets_.end();
  });
}

void StripRecorder::Add(const vo::FrameResult& result,
                        const std::function<vo::StereoFrame()>& images) {
  const bool is_reset = result.segment != segment_;
  segment_ = result.segment;
  const bool keeps_reset = is_reset && resets_.size() < kMostResets;
  if (keeps_reset) {
    resets_.push_back(index_);
  }
  if (keeps_reset || IsChosen()) {
    const vo::StereoFrame frame = images();
    StripFrame kept;
    kept.index = index_;
    kept.timestamp_ns = result.timestamp_ns;
    kept.is_reset = is_reset;
    kept.width = frame.images[0].cols;
    kept.height = frame.images[0].rows;
    kept.left_jpeg = EncodeJpeg(frame.images[0]);
    kept.right_jpeg = EncodeJpeg(frame.images[1]);
    for (const vo::Observation& observation : result.tracked_frame.observations) {
      const Eigen::Vector2f left = observation.left_pixel.cast<float>();
      if (const auto last = last_left_.find(observation.track_id); last != last_left_.end()) {
        kept.tracked.push_back({last->second, left});
      } else {
        kept.new_points.push_back(left);
      }
      if (observation.has_right) {
        kept.stereo.push_back({left, observation.right_pixel.cast<float>()});
      }
    }
    frames_.push_back(std::move(kept));
    Thin();
  }
  last_left_.clear();
  for (const vo::Observation& observation : result.tracked_frame.observations) {
    last_left_[observation.track_id] = observation.left_pixel.cast<float>();
  }
  ++index_;
}

namespace {

class Overlay {
 public:
  Overlay(const StripFrame& frame, const std::vector<uint8_t>& jpeg)
      : frame_(frame),
        scale_(kDrawingWidth / frame.width),
        svg_("<svg viewBox=\"0 0 " + Coordinate(kDrawingWidth) + " " + Coordinate(Height()) +
             "\" role=\"img\"><image width=\"" + Coordinate(kDrawingWidth) + "\" height=\"" +
             Coordinate(Height()) +
             "\" preserveAspectRatio=\"none\" href=\"data:image/jpeg;base64," + Base64(jpeg) +
             "\"/>") {}

  void Lines(const std::vector<PixelMotion>& motions) {
    std::string lines;
    std::vector<Eigen::Vector2f> ends;
    for (const PixelMotion& motion : motions) {
      lines += "M" + Place(motion.from) + "L" + Place(motion.to);
      ends.push_back(motion.to);
    }
    Add("halo", lines);
    Add("motion", lines);
    Dots("end", ends);
  }

  void Dots(const std::string& style, const std::vector<Eigen::Vector2f>& points) {
    std::string dots;
    for (const Eigen::Vector2f& point : points) {
      dots += "M" + Place(point) + "h0";
    }
    Add("dot " + style, dots);
  }

  std::string Finish(const std::string& caption) const {
    return "<figure>" + svg_ + "</svg><figcaption>" + caption + "</figcaption></figure>\n";
  }

 private:
  double Height() const { return kDrawingWidth * frame_.height / frame_.width; }
  // Pixels of the drawing begin at the corner of the image, those of images at their centre.
  std::string Place(const Eigen::Vector2f& pixel) const {
    return Coordinate(scale_ * (pixel.x() + 0.5)) + " " + Coordinate(scale_ * (pixel.y() + 0.5));
  }
  void Add(const std::string& style, const std::string& path) {
    if (!path.empty()) {
      svg_ += "<path class=\"" + style + "\" d=\"" + path + "\"/>";
    }
  }

  const StripFrame& frame_;
  double scale_;
  std::string svg_;
};

}  // namespace

std::string DrawStrip(const std::vector<StripFrame>& frames, int64_t start_ns) {
  std::string html = "<div class=\"strip\">\n";
  for (const StripFrame& frame : frames) {
    Overlay left(frame, frame.left_jpeg);
    left.Dots("new", frame.new_points);
    left.Lines(frame.tracked);
    html += left.Finish(
        "<b>Frame " + std::to_string(frame.index) + "</b>, " +
        Fixed(static_cast<double>(frame.timestamp_ns - start_ns) * 1e-9, 1) + " s" +
        (frame.is_reset ? " <span class=\"lost\">tracking lost, new segment</span>" : "") +
        ". Left: " + std::to_string(frame.tracked.size()) + " tracked, " +
        std::to_string(frame.new_points.size()) + " new");
    Overlay right(frame, frame.right_jpeg);
    right.Lines(frame.stereo);
    html += right.Finish("Right: " + std::to_string(frame.stereo.size()) + " stereo matches");
  }
  return html + "</div>\n";
}

}  // namespace gluevo::apps
