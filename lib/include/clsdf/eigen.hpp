#pragma once

/// Eigen's matrices as meshes. This is the only public header that needs Eigen.
#include <clsdf/error.hpp>
#include <clsdf/mesh.hpp>

#include <Eigen/Core>

#include <cstddef>
#include <string>
#include <type_traits>

namespace clsdf {

namespace detail {

template <typename Matrix>
InputArray triples_of(const Eigen::MatrixBase<Matrix>& any, const char* what) {
    static_assert(Matrix::Flags & Eigen::DirectAccessBit,
                  "clsdf::mesh_view looks at matrices, maps, blocks and references; evaluate an expression first");
    constexpr int rows = Matrix::RowsAtCompileTime, columns = Matrix::ColsAtCompileTime;
    static_assert(rows == 3 || columns == 3 || (rows == Eigen::Dynamic && columns == Eigen::Dynamic),
                  "clsdf::mesh_view takes n x 3 or 3 x n matrices");
    const Matrix& matrix = any.derived();
    const bool row_by_row = columns == 3 || (rows != 3 && matrix.cols() == 3);
    if (!row_by_row && matrix.rows() != 3)
        throw Error(ErrorCode::invalid_argument,
                    std::string("the matrix of ") + what + " has " + std::to_string(matrix.rows()) + " x " +
                        std::to_string(matrix.cols()) + " numbers; n x 3 or 3 x n make triples");
    constexpr auto width = static_cast<std::ptrdiff_t>(sizeof(typename Matrix::Scalar));
    const std::ptrdiff_t rows_apart = matrix.rowStride() * width, columns_apart = matrix.colStride() * width;
    return row_by_row ? InputArray(matrix.data(), static_cast<std::size_t>(matrix.rows()), rows_apart, columns_apart)
                      : InputArray(matrix.data(), static_cast<std::size_t>(matrix.cols()), columns_apart, rows_apart);
}

}  // namespace detail

/// A view of a mesh in Eigen's matrices, maps, blocks or references. It copies nothing and must not outlive them. The
/// matrices are n x 3, a row per vertex or triangle (libigl's V and F), or 3 x n, a column per vertex or triangle; row-
/// or column-major, with gaps or without. A 3 x 3 matrix of dynamic size counts as rows. Vertices are double or float,
/// indices have 32 or 64 bits. Throws Error(invalid_argument) if a matrix of dynamic size has neither 3 rows nor 3
/// columns.
template <typename Vertices, typename Triangles>
MeshView mesh_view(const Eigen::MatrixBase<Vertices>& vertices, const Eigen::MatrixBase<Triangles>& triangles) {
    using Index = typename Triangles::Scalar;
    static_assert(std::is_same_v<typename Vertices::Scalar, double> || std::is_same_v<typename Vertices::Scalar, float>,
                  "clsdf::mesh_view takes vertices in double or float");
    static_assert(std::is_integral_v<Index> && (sizeof(Index) == 4 || sizeof(Index) == 8),
                  "clsdf::mesh_view takes indices of 32 or 64 bits");
    return {detail::triples_of(vertices, "vertices"), detail::triples_of(triangles, "triangles")};
}

}  // namespace clsdf
