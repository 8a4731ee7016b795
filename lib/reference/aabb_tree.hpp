#pragma once

// CGAL's AABB tree in three dimensions, by one name: since CGAL 6 its headers and classes end in _3, and those without
// are deprecated.
#if __has_include(<CGAL/AABB_traits_3.h>)
#include <CGAL/AABB_traits_3.h>
#include <CGAL/AABB_triangle_primitive_3.h>
#else
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_triangle_primitive.h>
#endif
#include <CGAL/AABB_tree.h>

namespace clsdf::reference {

#if __has_include(<CGAL/AABB_traits_3.h>)
template <typename Kernel, typename Primitive>
using AabbTraits = CGAL::AABB_traits_3<Kernel, Primitive>;
template <typename Kernel, typename Iterator>
using AabbTriangle = CGAL::AABB_triangle_primitive_3<Kernel, Iterator>;
#else
template <typename Kernel, typename Primitive>
using AabbTraits = CGAL::AABB_traits<Kernel, Primitive>;
template <typename Kernel, typename Iterator>
using AabbTriangle = CGAL::AABB_triangle_primitive<Kernel, Iterator>;
#endif

}  // namespace clsdf::reference
