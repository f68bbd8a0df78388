// Uses each installed layer. Exit code 0 where all do their work.

#include <gluevo/nn/superglue.h>
#include <gluevo/nn/superpoint.h>
#include <gluevo/vo/evaluation/evaluation.h>
#include <gluevo/vo/pipeline/odometry.h>
#include <gluevo/weights_tools/architecture.h>

#include <cstdint>
#include <iostream>
#include <string>
#include <vector>

int main() {
  constexpr int kSide = 96;
  std::vector<uint8_t> pixels(kSide * kSide);
  for (int i = 0; i < kSide * kSide; ++i) {
    const int tile = i / kSide / 12 * 8 + i % kSide / 12;
    pixels[static_cast<std::size_t>(i)] = static_cast<uint8_t>(tile * tile * 37);
  }

  gluevo::nn::ThreadPool pool(1);
  gluevo::nn::Workspace workspace(pool);
  gluevo::nn::Features features;
  gluevo::nn::SuperPoint(gluevo::nn::OpenSuperPointWeights())
      .Extract({pixels.data(), kSide, kSide, kSide}, {}, workspace, features);
  gluevo::nn::Matches matches;
  gluevo::nn::SuperGlue(gluevo::nn::OpenSuperGlueWeights())
      .Match(features, features, {}, workspace, matches);
  int right = 0;
  for (int i = 0; i < features.size(); ++i) {
    right += matches.matches0[static_cast<std::size_t>(i)] == i ? 1 : 0;
  }
  std::cout << features.size() << " keypoints, " << right << " matched with themselves\n";

  gluevo::vo::StereoRig rig;
  for (gluevo::vo::Camera& camera : rig.cameras) {
    camera = {.width = kSide, .height = kSide, .fx = 90, .fy = 90, .cx = 48, .cy = 48};
  }
  rig.body_from_cam[1].translation = {0.1, 0.0, 0.0};
  gluevo::vo::OdometryConfig config;
  config.frontend.method = "klt";
  gluevo::vo::Odometry odometry(rig, config);
  const cv::Mat image(kSide, kSide, CV_8UC1, pixels.data());
  const gluevo::vo::FrameResult result = odometry.Process({1, {image, image}});
  std::cout << result.observations << " corners\n";

  const std::vector<Eigen::Vector3d> triangle = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const std::vector<Eigen::Vector3d> twice = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}};
  const double scale = gluevo::vo::AlignUmeyama(triangle, twice, /*with_scale=*/true).scale;
  const std::string text = gluevo::weights_tools::NetworkName(
      gluevo::weights_tools::ReadArchitecture(gluevo::nn::OpenSuperPointWeights()));
  std::cout << "scale " << scale << '\n' << text << '\n';
  return right > 0 && result.observations > 0 && scale > 1.999 && scale < 2.001 && !text.empty()
             ? 0
             : 1;
}
