#include "packed_linear.h"

namespace gluevo::nn {

template <typename Operand>
Linear<Operand> Packer<Operand>::Pack(const Affine& affine, int64_t columns) {
  using Matrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const Matrix weight = affine.weight.template cast<float>();
  Matrix padded = Matrix::Zero(columns, weight.cols());
  padded.topRows(weight.rows()) = weight;
  Linear<Operand> linear;
  linear.blocks0 = kernels::ElementBlocks<Operand>(weight.cols());
  linear.columns = columns;
  linear.weights = to_;
  kernels::PackMatrix(padded.data(), padded.cols(), columns, padded.cols(), to_);
  to_ += kernels::PackedMatrixSize<Operand>(columns, padded.cols());
  linear.bias = Tensor<float>({columns});
  linear.bias.view().Vector().head(affine.bias.size()) = affine.bias.template cast<float>();
  return linear;
}

Affine PadHeads(const Affine& affine, int64_t heads, int64_t padded) {
  const int64_t head_size = affine.bias.size() / heads;
  Affine result;
  result.weight.setZero(heads * padded, affine.weight.cols());
  result.bias.setZero(heads * padded);
  for (int64_t head = 0; head < heads; ++head) {
    result.weight.middleRows(head * padded, head_size) =
        affine.weight.middleRows(head * head_size, head_size);
    result.bias.segment(head * padded, head_size) =
        affine.bias.segment(head * head_size, head_size);
  }
  return result;
}

template class Packer<float>;
template class Packer<kernels::Bf16Pair>;

}  // namespace gluevo::nn
