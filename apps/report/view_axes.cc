#include "view_axes.h"

#include <utility>

namespace gluevo::apps {

ViewAxes ChooseViewAxes(const Eigen::Vector3d& up, const Eigen::AlignedBox3d& box) {
  ViewAxes axes;
  up.cwiseAbs().maxCoeff(&axes.up.index);
  axes.up.sign = up[axes.up.index] < 0.0 ? -1 : 1;
  // For up = z that is x to the right and y up the page; seen against an axis, the two swap.
  axes.right.index = (axes.up.index + 1) % 3;
  axes.forward.index = (axes.up.index + 2) % 3;
  if (axes.up.sign < 0) {
    std::swap(axes.right.index, axes.forward.index);
  }
  // A nearly square path need not be turned.
  constexpr double kClearlyLonger = 1.2;
  if (!box.isEmpty() &&
      box.sizes()[axes.forward.index] > kClearlyLonger * box.sizes()[axes.right.index]) {
    const SignedAxis right = axes.right;
    axes.right = axes.forward;
    axes.forward = {right.index, -1};
  }
  return axes;
}

}  // namespace gluevo::apps
