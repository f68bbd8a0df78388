#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <initializer_list>
#include <memory>
#include <new>
#include <string>
#include <type_traits>
#include <utility>

#include "gluevo/nn/error.h"

namespace gluevo::nn {

/// Alignment in bytes of every tensor: a cache line, and the widest vector register.
inline constexpr std::size_t kAlignment = 64;

/// The extents of a tensor, outermost first; rank 0 (a scalar) to 4.
class Shape {
 public:
  static constexpr int kMaxRank = 4;

  Shape() = default;
  /// Throws Error for a rank above kMaxRank, a negative extent or a size that overflows, extents of
  /// zero not counted.
  Shape(std::initializer_list<int64_t> extents) : Shape(extents.begin(), extents.size()) {}
  Shape(const int64_t* extents, std::size_t rank);

  int rank() const { return rank_; }
  int64_t operator[](int axis) const { return extents_[axis]; }
  /// Number of elements; 1 for a scalar.
  int64_t size() const { return size_; }
  /// "[64 x 3 x 3]", for messages.
  std::string ToString() const;

  friend bool operator==(const Shape&, const Shape&) = default;

 private:
  std::array<int64_t, kMaxRank> extents_ = {};
  int64_t size_ = 1;
  int rank_ = 0;
};

/// Throws Error "WHAT has shape A, expected B" unless the two agree.
void CheckShape(const Shape& actual, const Shape& expected, const std::string& what);

/// A row-major, contiguous tensor whose elements somebody else owns.
template <typename T>
class TensorView {
 public:
  using Scalar = std::remove_const_t<T>;
  using MatrixMap = Eigen::Map<std::conditional_t<
      std::is_const_v<T>,
      const Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>,
      Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>>;
  using VectorMap = Eigen::Map<
      std::conditional_t<std::is_const_v<T>, const Eigen::Matrix<Scalar, Eigen::Dynamic, 1>,
                         Eigen::Matrix<Scalar, Eigen::Dynamic, 1>>>;

  TensorView() = default;
  TensorView(T* data, const Shape& shape) : data_(data), shape_(shape) {}
  /// A view of mutable elements serves as a view of constant ones.
  template <typename U>
  requires(std::is_const_v<T>&& std::is_same_v<U, Scalar>)
      TensorView(const TensorView<U>& other)  // NOLINT(google-explicit-constructor)
      : data_(other.data()), shape_(other.shape()) {}

  T* data() const { return data_; }
  const Shape& shape() const { return shape_; }
  int64_t size() const { return shape_.size(); }
  int64_t extent(int axis) const { return shape_[axis]; }
  T& operator[](int64_t i) const { return data_[i]; }

  /// The last axis as columns, all others together as rows.
  MatrixMap Matrix() const {
    const int64_t columns = shape_.rank() == 0 ? 1 : shape_[shape_.rank() - 1];
    return MatrixMap(data_, columns == 0 ? 0 : size() / columns, columns);
  }
  VectorMap Vector() const { return VectorMap(data_, size()); }
  /// The same elements under another shape of the same size; throws Error for another size.
  TensorView Reshaped(const Shape& shape) const {
    CheckShape(Shape{shape.size()}, Shape{size()}, "reshaped tensor");
    return TensorView(data_, shape);
  }

 private:
  T* data_ = nullptr;
  Shape shape_ = {0};
};

/// A row-major, contiguous tensor that owns its elements, aligned to kAlignment.
template <typename T>
class Tensor {
 public:
  static_assert(std::is_trivially_copyable_v<T>);

  Tensor() = default;
  /// All elements zero.
  explicit Tensor(const Shape& shape) : data_(Allocate(shape.size())), shape_(shape) {
    std::fill_n(data_.get(), shape.size(), T{});
  }
  Tensor(const Tensor& other) : data_(Allocate(other.size())), shape_(other.shape_) {
    std::copy_n(other.data(), size(), data_.get());
  }
  Tensor(Tensor&& other) noexcept
      : data_(std::move(other.data_)), shape_(std::exchange(other.shape_, Shape{0})) {}
  Tensor& operator=(Tensor other) noexcept {
    std::swap(data_, other.data_);
    std::swap(shape_, other.shape_);
    return *this;
  }
  ~Tensor() = default;

  T* data() { return data_.get(); }
  const T* data() const { return data_.get(); }
  const Shape& shape() const { return shape_; }
  int64_t size() const { return shape_.size(); }
  int64_t extent(int axis) const { return shape_[axis]; }
  T& operator[](int64_t i) { return data_.get()[i]; }
  const T& operator[](int64_t i) const { return data_.get()[i]; }

  TensorView<T> view() { return {data_.get(), shape_}; }
  TensorView<const T> view() const { return {data_.get(), shape_}; }
  typename TensorView<T>::MatrixMap Matrix() { return view().Matrix(); }
  typename TensorView<const T>::MatrixMap Matrix() const { return view().Matrix(); }

 private:
  struct Free {
    void operator()(T* p) const { ::operator delete (p, std::align_val_t{kAlignment}); }
  };
  static std::unique_ptr<T, Free> Allocate(int64_t count) {
    return std::unique_ptr<T, Free>(static_cast<T*>(::operator new (
        static_cast<std::size_t>(count) * sizeof(T), std::align_val_t{kAlignment})));
  }

  std::unique_ptr<T, Free> data_;
  Shape shape_ = {0};
};

}  // namespace gluevo::nn
