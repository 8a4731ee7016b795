#pragma once

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

/// The part of OpenCL C in which those headers of kernels are written that the host compiles, too. Such a header is
/// included in a namespace that uses this one, with LANES 1 and empty address spaces. The operations are those of the
/// kernels, rounded in the same way.
namespace clsdf::kernel_language {

using uchar = std::uint8_t;
using ushort = std::uint16_t;
using uint = std::uint32_t;
using ulong = std::uint64_t;
using std::fabs;
using std::sqrt;
inline float rsqrt(float x) {
    return 1 / sqrt(x);
}

template <typename T>
float as_float(T x) {
    return std::bit_cast<float>(x);
}
template <typename T>
uint as_uint(T x) {
    return std::bit_cast<uint>(x);
}
inline double as_double(ulong x) {
    return std::bit_cast<double>(x);
}

/// The second of two numbers if the condition holds.
template <typename T, typename Condition>
T select(T otherwise, T if_true, Condition condition) {
    return condition ? if_true : otherwise;
}

template <typename T>
struct Vector2 {
    T x, y;

    Vector2() = default;
    Vector2(T x_in, T y_in) : x(x_in), y(y_in) {}
    explicit Vector2(T all) : x(all), y(all) {}

    /// Combines each pair of components.
    template <typename Combine>
    friend Vector2 combined(const Vector2& a, const Vector2& b, const Combine& combine) {
        return {combine(a.x, b.x), combine(a.y, b.y)};
    }
};

template <typename T>
struct Vector3 {
    T x, y, z;

    Vector3() = default;
    Vector3(T x_in, T y_in, T z_in) : x(x_in), y(y_in), z(z_in) {}
    explicit Vector3(T all) : x(all), y(all), z(all) {}

    template <typename Combine>
    friend Vector3 combined(const Vector3& a, const Vector3& b, const Combine& combine) {
        return {combine(a.x, b.x), combine(a.y, b.y), combine(a.z, b.z)};
    }
};

template <typename T>
struct Vector4 {
    T x, y, z, w;

    Vector4() = default;
    Vector4(T x_in, T y_in, T z_in, T w_in) : x(x_in), y(y_in), z(z_in), w(w_in) {}

    template <typename Combine>
    friend Vector4 combined(const Vector4& a, const Vector4& b, const Combine& combine) {
        return {combine(a.x, b.x), combine(a.y, b.y), combine(a.z, b.z), combine(a.w, b.w)};
    }
};

template <template <typename> class V, typename T>
V<T> operator+(const V<T>& a, const V<T>& b) {
    return combined(a, b, [](T s, T t) { return s + t; });
}
template <template <typename> class V, typename T>
V<T> operator-(const V<T>& a, const V<T>& b) {
    return combined(a, b, [](T s, T t) { return s - t; });
}
template <template <typename> class V, typename T>
V<T> operator*(const V<T>& a, const V<T>& b) {
    return combined(a, b, [](T s, T t) { return s * t; });
}
template <template <typename> class V, typename T>
V<T> operator*(const V<T>& a, T factor) {
    return combined(a, a, [factor](T s, T) { return s * factor; });
}
template <template <typename> class V, typename T>
V<T> operator*(T factor, const V<T>& a) {
    return a * factor;
}
template <template <typename> class V, typename T>
V<T> operator-(const V<T>& a) {
    return combined(a, a, [](T s, T) { return -s; });
}
using uint2 = Vector2<uint>;
using uint3 = Vector3<uint>;
using uint4 = Vector4<uint>;
using ulong2 = Vector2<ulong>;
using ulong3 = Vector3<ulong>;
using float2 = Vector2<float>;
using float3 = Vector3<float>;
using float4 = Vector4<float>;
using double2 = Vector2<double>;
using double3 = Vector3<double>;
using double4 = Vector4<double>;

/// Numbers [N i, N i + N) of an array. They may be those of the next members of its struct.
template <typename V, typename T>
V loaded(std::size_t i, const T* numbers) {
    V values;
    std::memcpy(&values, reinterpret_cast<const std::byte*>(numbers) + i * sizeof(V), sizeof(V));
    return values;
}
template <typename T>
Vector2<T> vload2(std::size_t i, const T* numbers) {
    return loaded<Vector2<T>>(i, numbers);
}
template <typename T>
Vector3<T> vload3(std::size_t i, const T* numbers) {
    return loaded<Vector3<T>>(i, numbers);
}
template <typename T>
Vector4<T> vload4(std::size_t i, const T* numbers) {
    return loaded<Vector4<T>>(i, numbers);
}

template <typename T>
void vstore2(const Vector2<T>& values, std::size_t i, T* numbers) {
    numbers[2 * i] = values.x;
    numbers[2 * i + 1] = values.y;
}
template <typename T>
void vstore3(const Vector3<T>& values, std::size_t i, T* numbers) {
    numbers[3 * i] = values.x;
    numbers[3 * i + 1] = values.y;
    numbers[3 * i + 2] = values.z;
}

template <typename T>
Vector2<float> convert_float2(const Vector2<T>& v) {
    return {static_cast<float>(v.x), static_cast<float>(v.y)};
}
template <typename T>
Vector3<float> convert_float3(const Vector3<T>& v) {
    return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}
template <typename T>
double3 convert_double3(const Vector3<T>& v) {
    return {static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)};
}

}  // namespace clsdf::kernel_language
