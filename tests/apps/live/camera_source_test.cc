#include "camera_source.h"

#include <gtest/gtest.h>

#include <map>

#include "message_of.h"

namespace gluevo::apps {
namespace {

constexpr int64_t kMs = 1'000'000;

// Cameras of a test: every image is 50 ms after the one before and shows its number.
struct Cameras {
  struct One {
    int64_t next_ns = 0;
    int images_left = 1'000'000;  // Until it is gone.
    int tries_until_back = 0;
    int width = 16;
  };
  std::map<std::string, One> cameras;
  int64_t now_ns = 0;

  class Device final : public VideoDevice {
   public:
    Device(Cameras& all, One& one) : all_(all), one_(one) {}
    bool Grab() override {
      if (one_.images_left == 0) {
        return false;
      }
      --one_.images_left;
      stamp_ns_ = one_.next_ns;
      one_.next_ns += 50 * kMs;
      all_.now_ns = std::max(all_.now_ns, stamp_ns_ + 8 * kMs);
      return true;
    }
    std::optional<int64_t> StampNs() override { return stamp_ns_; }
    bool Retrieve(cv::Mat& gray) override {
      const auto number = static_cast<double>(stamp_ns_ / kMs / 50);
      gray = cv::Mat(8, one_.width, CV_8UC1, cv::Scalar(number));
      gray.colRange(one_.width / 2, one_.width).setTo(cv::Scalar(100 + number));
      return true;
    }

   private:
    Cameras& all_;
    One& one_;
    int64_t stamp_ns_ = 0;
  };

  OpenVideo Open() {
    return [this](const std::string& name) -> std::unique_ptr<VideoDevice> {
      const auto found = cameras.find(name);
      if (found == cameras.end()) {
        return nullptr;
      }
      if (found->second.images_left == 0) {
        if (found->second.tries_until_back-- > 0) {
          return nullptr;
        }
        found->second.images_left = 1'000'000;
        found->second.next_ns = now_ns;
      }
      return std::make_unique<Device>(*this, found->second);
    };
  }
  SourceClock Clock() {
    return {[this] { return now_ns; }, [this](int64_t until_ns) { now_ns = until_ns; }};
  }
};

TEST(CameraSourceTest, OneCameraShowsBothSideBySide) {
  Cameras cameras{.cameras = {{"both", {}}}};
  CameraSource source({.cameras = {"both"}}, cameras.Open(), cameras.Clock());
  EXPECT_EQ(source.image_size(), cv::Size(8, 8));
  for (int i = 1; i < 4; ++i) {
    const SourceEvent event = source.Next();
    ASSERT_TRUE(event.frame);
    EXPECT_EQ(event.frame->timestamp_ns, i * 50 * kMs);  // The driver's stamp.
    EXPECT_EQ(event.frame->images[0].at<uchar>(3, 3), i);
    EXPECT_EQ(event.frame->images[1].at<uchar>(3, 3), 100 + i);
    EXPECT_EQ(event.frame->images[1].size(), cv::Size(8, 8));
  }
}

TEST(CameraSourceTest, ACameraThatIsAFrameBehindIsCaughtUp) {
  Cameras cameras{.cameras = {{"left", {}}, {"right", {}}}};
  CameraSource source({.cameras = {"left", "right"}}, cameras.Open(), cameras.Clock());
  source.Next();
  cameras.cameras["left"].next_ns += 100 * kMs;  // It has lost two images.
  const SourceEvent event = source.Next();
  ASSERT_TRUE(event.frame);
  EXPECT_EQ(event.frame->images[0].at<uchar>(0, 0), 4);
  EXPECT_EQ(event.frame->images[1].at<uchar>(0, 0), 4);
  EXPECT_EQ(source.counts().frames_unpaired, 2);
}

TEST(CameraSourceTest, ACameraThatIsGoneIsOpenedAgain) {
  Cameras cameras{.cameras = {{"left", {}}, {"right", {.images_left = 3, .tries_until_back = 4}}}};
  CameraSource source({.cameras = {"left", "right"}}, cameras.Open(), cameras.Clock());
  std::vector<std::string> warnings;
  int frames = 0;
  for (int i = 0; i < 30; ++i) {
    const SourceEvent event = source.Next();
    frames += event.frame ? 1 : 0;
    if (!event.warning.empty()) {
      warnings.push_back(event.warning);
    }
  }
  ASSERT_EQ(warnings.size(), 2U);
  EXPECT_EQ(warnings[0], "right: the camera is gone, it is waited for");
  EXPECT_EQ(warnings[1], "right: the camera is back after 0.8 s");
  EXPECT_EQ(source.counts().cameras_gone, 1);
  EXPECT_EQ(frames, 24);
}

TEST(CameraSourceTest, AtSomeTimeItIsGivenUp) {
  Cameras cameras{.cameras = {{"both", {.images_left = 2, .tries_until_back = 1000}}}};
  CameraSource source({.cameras = {"both"}, .give_up_s = 3.0}, cameras.Open(), cameras.Clock());
  EXPECT_EQ(MessageOf([&] {
              for (int i = 0; i < 100; ++i) {
                source.Next();
              }
            }),
            "both: the camera is gone for more than 3 s");
}

TEST(CameraSourceTest, WhatIsNoCameraIsNamed) {
  Cameras cameras{.cameras = {{"none", {.images_left = 0, .tries_until_back = 1}},
                              {"left", {}},
                              {"wide", {.width = 32}}}};
  const auto message = [&](const std::vector<std::string>& names) {
    return MessageOf([&] { CameraSource({.cameras = names}, cameras.Open(), cameras.Clock()); });
  };
  EXPECT_EQ(message({"left", "absent"}).substr(0, 35), "absent: cannot be opened as a camer");
  EXPECT_EQ(message({"none"}).substr(0, 22), "none: cannot be opened");
  EXPECT_EQ(message({"left", "wide"}),
            "wide: gives images of 32x8; expected 16x8, as the first one was");
}

}  // namespace
}  // namespace gluevo::apps
