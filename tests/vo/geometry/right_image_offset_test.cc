#include "gluevo/vo/geometry/right_image_offset.h"

#include <gtest/gtest.h>

#include "gluevo/vo/geometry/manifold.h"

namespace gluevo::vo {
namespace {

const Eigen::Vector3d kTurn(4e-4, -3e-4, 2e-4);
const Eigen::Vector2d kSeen(0.6, -0.3);

TEST(RightImageOffset, WithItsBendItIsATurnedCamera) {
  const Eigen::Vector2d moved =
      (RightImageOffset{kTurn, 1.0}.Matrix() * kSeen.homogeneous()).hnormalized();
  const Eigen::Vector2d turned = (ExpSo3(kTurn) * kSeen.homogeneous()).hnormalized();
  EXPECT_LT((moved - turned).norm(), kTurn.squaredNorm());
  EXPECT_GT((turned - kSeen).norm(), 1e-4);
}

TEST(RightImageOffset, WithoutItsBendItMovesTheImageAsAWhole) {
  const Eigen::Vector3d no_roll(kTurn.x(), kTurn.y(), 0.0);
  const RightImageOffset shifted{no_roll, 0.0};
  for (const Eigen::Vector2d& seen : {Eigen::Vector2d(0.0, 0.0), kSeen}) {
    const Eigen::Vector2d moved = (shifted.Matrix() * seen.homogeneous()).hnormalized();
    EXPECT_LT((moved - seen - Eigen::Vector2d(kTurn.y(), -kTurn.x())).norm(), 1e-15);
  }
}

TEST(RightImageOffset, UndoIsItsInverse) {
  for (const double bend : {0.0, 0.5, 1.0}) {
    const RightImageOffset correction{kTurn, bend};
    const Eigen::Vector2d moved = (correction.Matrix() * kSeen.homogeneous()).hnormalized();
    EXPECT_LT((RightImageUndo(correction)(moved) - kSeen).norm(), 1e-15);
  }
}

TEST(RightImageOffset, ByTurnIsItsDerivative) {
  const Eigen::Vector3d point(1.0, -2.0, 4.0);
  for (const double bend : {0.0, 0.5, 1.0}) {
    const RightImageOffset correction{kTurn, bend};
    for (int axis = 0; axis < 3; ++axis) {
      // Linear in the turn, so that any step will do.
      const Eigen::Vector3d step = 0.5 * Eigen::Vector3d::Unit(axis);
      const Eigen::Vector3d numeric = RightImageOffset{kTurn + step, bend}.Matrix() * point -
                                      RightImageOffset{kTurn - step, bend}.Matrix() * point;
      EXPECT_LT((correction.ByTurn(point).col(axis) - numeric).norm(), 1e-12);
    }
  }
}

}  // namespace
}  // namespace gluevo::vo
