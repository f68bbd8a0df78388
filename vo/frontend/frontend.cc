#include "gluevo/vo/frontend/frontend.h"

#include <string>

#include "gluevo/nn/error.h"

namespace gluevo::vo {

void CheckImages(const StereoFrame& frame, const StereoRig& rig) {
  for (const int i : {0, 1}) {
    const cv::Mat& image = frame.images[i];
    const Camera& camera = rig.cameras[i];
    const std::string which = i == 0 ? "the left image" : "the right image";
    if (image.type() != CV_8UC1) {
      throw Error(which + " has " + std::to_string(image.channels()) + " channels of " +
                  std::to_string(8 * image.elemSize1()) + " bits; expected 8-bit gray");
    }
    if (image.cols != camera.width || image.rows != camera.height) {
      throw Error(which + " is " + std::to_string(image.cols) + "x" + std::to_string(image.rows) +
                  ", its camera " + std::to_string(camera.width) + "x" +
                  std::to_string(camera.height));
    }
  }
}

}  // namespace gluevo::vo
