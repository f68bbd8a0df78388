#include "reprojection_factors.h"

#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "pose_manifold.h"
#include "vo/scene.h"

namespace gluevo::vo {
namespace {

constexpr double kWeight = 460.0 / 1.5;

// Compares every Jacobian of `cost` with central differences, relative to the Jacobian's largest
// entry. The fourth-order formula has a truncation error of h^4 f'''''/30 and a rounding error of
// about eps * |f| / h: with h = 1e-3 relative to the scale of a parameter, both are below 1e-10.
void ExpectJacobiansMatch(const ceres::CostFunction& cost, std::vector<std::vector<double>> x) {
  const auto residuals = [&](const std::vector<std::vector<double>>& parameters) {
    std::vector<const double*> pointers;
    for (const auto& block : parameters) {
      pointers.push_back(block.data());
    }
    Eigen::Vector2d r;
    EXPECT_TRUE(cost.Evaluate(pointers.data(), r.data(), nullptr));
    return r;
  };
  std::vector<const double*> pointers;
  std::vector<std::vector<double>> jacobians;
  std::vector<double*> jacobian_pointers;
  for (const auto& block : x) {
    pointers.push_back(block.data());
    jacobians.emplace_back(2 * block.size(), 123.0);
  }
  for (auto& jacobian : jacobians) {
    jacobian_pointers.push_back(jacobian.data());
  }
  Eigen::Vector2d r;
  ASSERT_TRUE(cost.Evaluate(pointers.data(), r.data(), jacobian_pointers.data()));
  EXPECT_EQ(r, residuals(x));
  for (std::size_t block = 0; block < x.size(); ++block) {
    const std::size_t size = x[block].size();
    Eigen::MatrixXd numeric(2, size);
    for (std::size_t k = 0; k < size; ++k) {
      const double at = x[block][k];
      const double step = 1e-3 * (size == 3 && k == 2 ? at : 1.0);
      const auto sample = [&](double offset) {
        x[block][k] = at + offset;
        const Eigen::Vector2d value = residuals(x);
        x[block][k] = at;
        return value;
      };
      numeric.col(k) =
          (8.0 * (sample(step) - sample(-step)) - (sample(2.0 * step) - sample(-2.0 * step))) /
          (12.0 * step);
    }
    const Eigen::Map<Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor>> analytic(
        jacobians[block].data(), 2, size);
    EXPECT_LT((analytic - numeric).cwiseAbs().maxCoeff(), 1e-6 * numeric.cwiseAbs().maxCoeff())
        << "block " << block << "\nanalytic\n"
        << analytic << "\nnumeric\n"
        << numeric;
  }
}

struct Scene {
  StereoRig rig = testing::SimulatedRig();
  Rigid3 world_from_i{ExpSo3({0.1, -0.3, 0.2}), {1.0, -2.0, 0.5}};
  Rigid3 world_from_j{ExpSo3({0.15, -0.2, 0.4}), {1.4, -1.7, 0.3}};
  Eigen::Vector2d anchor{0.2, -0.1};
  double depth = 4.0;

  Eigen::Vector3d PointInWorld() const {
    return world_from_i * (rig.body_from_cam[0] * (depth * anchor.homogeneous()));
  }
  Eigen::Vector2d Seen(const Rigid3& world_from_body, int camera) const {
    return ((world_from_body * rig.body_from_cam[camera]).Inverse() * PointInWorld()).hnormalized();
  }
  std::vector<double> Landmark() const { return {anchor.x(), anchor.y(), 1.0 / depth}; }
  std::vector<std::vector<double>> Parameters() const {
    const PoseParameters i = ToParameters(world_from_i);
    const PoseParameters j = ToParameters(world_from_j);
    return {{i.begin(), i.end()}, {j.begin(), j.end()}, Landmark(), turn};
  }
  std::vector<double> turn = {0.0, 0.0, 0.0};
};

TEST(ReprojectionFactors, ResidualIsTheWeightedError) {
  const Scene scene;
  for (int camera = 0; camera < 2; ++camera) {
    const Eigen::Vector2d offset(0.01, -0.02);
    const OtherFrameReprojection cost(scene.rig.body_from_cam[0], scene.rig.body_from_cam[camera],
                                      scene.Seen(scene.world_from_j, camera) - offset, kWeight);
    const auto x = scene.Parameters();
    const std::array<const double*, 4> pointers = {x[0].data(), x[1].data(), x[2].data(),
                                                   x[3].data()};
    Eigen::Vector2d residual;
    ASSERT_TRUE(cost.Evaluate(pointers.data(), residual.data(), nullptr));
    EXPECT_LT((residual - kWeight * offset).norm(), 1e-10) << camera;
  }
  const Eigen::Vector2d offset(-0.003, 0.004);
  const std::vector<double> landmark = scene.Landmark();
  const std::array<const double*, 2> pointers = {landmark.data(), scene.turn.data()};
  Eigen::Vector2d residual;
  const SameFrameReprojection right(scene.rig.right_from_left(),
                                    scene.Seen(scene.world_from_i, 1) - offset, kWeight);
  ASSERT_TRUE(right.Evaluate(pointers.data(), residual.data(), nullptr));
  EXPECT_LT((residual - kWeight * offset).norm(), 1e-10);
  const SameFrameReprojection left({}, scene.anchor - offset, kWeight);
  ASSERT_TRUE(left.Evaluate(pointers.data(), residual.data(), nullptr));
  EXPECT_LT((residual - kWeight * offset).norm(), 1e-10);
}

TEST(ReprojectionFactors, JacobiansMatchCentralDifferences) {
  for (const auto& [depth, bend] : {std::pair(0.8, 1.0), {4.0, 0.0}, {4.0, 1.0}, {300.0, 0.5}}) {
    Scene scene;
    scene.depth = depth;
    scene.turn = {0.02, -0.01, 0.03};  // Far more than a calibration errs.
    for (int camera = 0; camera < 2; ++camera) {
      SCOPED_TRACE(::testing::Message() << "depth " << depth << " camera " << camera);
      ExpectJacobiansMatch(
          OtherFrameReprojection(scene.rig.body_from_cam[0], scene.rig.body_from_cam[camera],
                                 {0.3, 0.1}, kWeight, bend),
          scene.Parameters());
    }
    ExpectJacobiansMatch(
        SameFrameReprojection(scene.rig.right_from_left(), {0.3, 0.1}, kWeight, bend),
        {scene.Landmark(), scene.turn});
    ExpectJacobiansMatch(SameFrameReprojection({}, {0.3, 0.1}, kWeight, bend),
                         {scene.Landmark(), scene.turn});
  }
}

TEST(ReprojectionFactors, ATurnRotatesTheCamera) {
  const Scene scene;
  const Eigen::Vector3d turn(4e-4, -3e-4, 2e-4);
  Rigid3 body_from_turned = scene.rig.body_from_cam[1];
  body_from_turned.rotation = body_from_turned.rotation * ExpSo3(turn).conjugate();
  const Eigen::Vector2d seen_by_turned =
      ((scene.world_from_j * body_from_turned).Inverse() * scene.PointInWorld()).hnormalized();
  const OtherFrameReprojection cost(scene.rig.body_from_cam[0], scene.rig.body_from_cam[1],
                                    seen_by_turned, kWeight);
  const auto x = scene.Parameters();
  const std::array<const double*, 4> pointers = {x[0].data(), x[1].data(), x[2].data(),
                                                 turn.data()};
  Eigen::Vector2d residual;
  ASSERT_TRUE(cost.Evaluate(pointers.data(), residual.data(), nullptr));
  // The turn is a rotation to first order: what is left is of the order of its square.
  EXPECT_LT(residual.norm(), kWeight * turn.squaredNorm());
}

TEST(ReprojectionFactors, APointBehindGivesALargeConstant) {
  Scene scene;
  // j has turned around.
  scene.world_from_j.rotation = scene.world_from_i.rotation * ExpSo3({0.0, 0.0, 3.1});
  const OtherFrameReprojection cost(scene.rig.body_from_cam[0], scene.rig.body_from_cam[1],
                                    {0.0, 0.0}, kWeight);
  const auto x = scene.Parameters();
  const std::array<const double*, 4> pointers = {x[0].data(), x[1].data(), x[2].data(),
                                                 x[3].data()};
  Eigen::Vector2d residual;
  Eigen::Matrix<double, 2, 7, Eigen::RowMajor> jacobian;
  jacobian.setConstant(5.0);
  std::array<double*, 4> jacobians = {jacobian.data(), nullptr, nullptr, nullptr};
  ASSERT_TRUE(cost.Evaluate(pointers.data(), residual.data(), jacobians.data()));
  EXPECT_GT(residual.norm(), 100.0);
  EXPECT_TRUE(jacobian.isZero());
}

}  // namespace
}  // namespace gluevo::vo
