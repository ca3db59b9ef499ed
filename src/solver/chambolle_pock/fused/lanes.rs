//! The arithmetic of the pass in single and double precision, on vectors of the instruction set S.
//!
//! AVX2 and AVX-512 round a b + c once, in the same expressions, and therefore give the same bits; portable code rounds
//! it twice.

use pulp::bytemuck::{Pod, cast_slice, cast_slice_mut};
use pulp::{Arch, Simd};

type V<T, S> = <T as Real>::Vector<S>;

pub trait Real: Pod + Send + Sync {
    type Vector<S: Simd>: Pod;

    const ZERO: Self;
    /// Whether this is f64, the precision of everything outside the engine.
    const DOUBLE: bool;
    /// Too small to change a sum of numbers near 1, and still far above the subnormal numbers.
    const NEGLIGIBLE: f64;
    /// The distance from 1 to the next larger number.
    const EPSILON: f64;

    fn from_f64(x: f64) -> Self;
    fn to_f64(self) -> f64;

    fn splat<S: Simd>(simd: S, x: f64) -> V<Self, S>;
    fn add<S: Simd>(simd: S, a: V<Self, S>, b: V<Self, S>) -> V<Self, S>;
    fn sub<S: Simd>(simd: S, a: V<Self, S>, b: V<Self, S>) -> V<Self, S>;
    fn mul<S: Simd>(simd: S, a: V<Self, S>, b: V<Self, S>) -> V<Self, S>;
    /// a b + c
    fn mul_add<S: Simd>(simd: S, a: V<Self, S>, b: V<Self, S>, c: V<Self, S>) -> V<Self, S>;
    fn neg<S: Simd>(simd: S, a: V<Self, S>) -> V<Self, S>;
    fn div<S: Simd>(simd: S, a: V<Self, S>, b: V<Self, S>) -> V<Self, S>;
    fn min<S: Simd>(simd: S, a: V<Self, S>, b: V<Self, S>) -> V<Self, S>;
    fn max<S: Simd>(simd: S, a: V<Self, S>, b: V<Self, S>) -> V<Self, S>;
    fn sqrt<S: Simd>(simd: S, a: V<Self, S>) -> V<Self, S>;
    /// a < b ? c : d
    fn if_less<S: Simd>(
        simd: S,
        a: V<Self, S>,
        b: V<Self, S>,
        c: V<Self, S>,
        d: V<Self, S>,
    ) -> V<Self, S>;
    /// Whether a < b in any lane.
    fn any_less<S: Simd>(simd: S, a: V<Self, S>, b: V<Self, S>) -> bool;
    /// The maximum over all lanes.
    fn largest<S: Simd>(simd: S, a: V<Self, S>) -> f64;
    /// Turns groups of four numbers, stored one after another, into four vectors with one lane per group, in the order
    /// of [`lane_order`].
    fn deinterleave<S: Simd>(simd: S, groups: [V<Self, S>; 4]) -> [V<Self, S>; 4];
    /// The inverse of `deinterleave`.
    fn interleave<S: Simd>(simd: S, lanes: [V<Self, S>; 4]) -> [V<Self, S>; 4];
}

/// The largest number of lanes of a vector.
pub const MAX_LANES: usize = 16;

/// The number of lanes of a vector.
pub const fn width<T: Real, S: Simd>() -> usize {
    size_of::<T::Vector<S>>() / size_of::<T>()
}

/// A bound of |y|^2 as computed: up to it, |y| is less than lambda in spite of rounding.
pub fn surely_inside<T: Real>(lambda: f64) -> f64 {
    lambda.powi(2) * (1.0 - 8.0 * T::EPSILON)
}

/// As many groups of four as a vector has lanes, stored one after another; `group` returns the one of each position.
#[inline(always)]
pub fn gather<T: Real, S: Simd>(simd: S, group: impl Fn(usize) -> [T; 4]) -> [V<T, S>; 4] {
    let mut groups = [T::splat(simd, 0.0); 4];
    for (position, out) in cast_slice_mut::<_, [T; 4]>(&mut groups).iter_mut().enumerate() {
        *out = group(position);
    }
    groups
}

/// For each position, the lane in which [`Real::deinterleave`] puts its group.
pub fn lane_order<T: Real>(arch: Arch) -> Vec<usize> {
    struct Order<T>(std::marker::PhantomData<T>);
    impl<T: Real> pulp::WithSimd for Order<T> {
        type Output = Vec<usize>;

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) -> Vec<usize> {
            let lanes =
                T::deinterleave(simd, gather(simd, |position| [T::from_f64(position as f64); 4]));
            let position_of_lane: &[T] = cast_slice(&lanes[..1]);
            let mut order = vec![0; position_of_lane.len()];
            for (lane, position) in position_of_lane.iter().enumerate() {
                order[position.to_f64() as usize] = lane;
            }
            order
        }
    }
    arch.dispatch(Order::<T>(std::marker::PhantomData))
}

macro_rules! real {
    ($float:ty, $negligible:expr, $vector:ident, $splat:ident, $add:ident, $sub:ident, $mul:ident, $mul_add:ident,
     $neg:ident, $div:ident, $min:ident, $max:ident, $sqrt:ident, $less:ident, $select:ident, $first:ident,
     $largest:ident, $deinterleave:ident, $interleave:ident) => {
        impl Real for $float {
            type Vector<S: Simd> = S::$vector;

            const ZERO: Self = 0.0;
            const DOUBLE: bool = size_of::<Self>() == size_of::<f64>();
            const NEGLIGIBLE: f64 = $negligible;
            const EPSILON: f64 = <$float>::EPSILON as f64;

            #[inline(always)]
            fn from_f64(x: f64) -> Self {
                x as $float
            }
            #[inline(always)]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }
            #[inline(always)]
            fn splat<S: Simd>(simd: S, x: f64) -> S::$vector {
                simd.$splat(x as $float)
            }
            #[inline(always)]
            fn add<S: Simd>(simd: S, a: S::$vector, b: S::$vector) -> S::$vector {
                simd.$add(a, b)
            }
            #[inline(always)]
            fn sub<S: Simd>(simd: S, a: S::$vector, b: S::$vector) -> S::$vector {
                simd.$sub(a, b)
            }
            #[inline(always)]
            fn mul<S: Simd>(simd: S, a: S::$vector, b: S::$vector) -> S::$vector {
                simd.$mul(a, b)
            }
            #[inline(always)]
            fn mul_add<S: Simd>(
                simd: S,
                a: S::$vector,
                b: S::$vector,
                c: S::$vector,
            ) -> S::$vector {
                simd.$mul_add(a, b, c)
            }
            #[inline(always)]
            fn neg<S: Simd>(simd: S, a: S::$vector) -> S::$vector {
                simd.$neg(a)
            }
            #[inline(always)]
            fn div<S: Simd>(simd: S, a: S::$vector, b: S::$vector) -> S::$vector {
                simd.$div(a, b)
            }
            #[inline(always)]
            fn min<S: Simd>(simd: S, a: S::$vector, b: S::$vector) -> S::$vector {
                simd.$min(a, b)
            }
            #[inline(always)]
            fn max<S: Simd>(simd: S, a: S::$vector, b: S::$vector) -> S::$vector {
                simd.$max(a, b)
            }
            #[inline(always)]
            fn sqrt<S: Simd>(simd: S, a: S::$vector) -> S::$vector {
                simd.$sqrt(a)
            }
            #[inline(always)]
            fn if_less<S: Simd>(
                simd: S,
                a: S::$vector,
                b: S::$vector,
                c: S::$vector,
                d: S::$vector,
            ) -> S::$vector {
                simd.$select(simd.$less(a, b), c, d)
            }
            #[inline(always)]
            fn any_less<S: Simd>(simd: S, a: S::$vector, b: S::$vector) -> bool {
                simd.$first(simd.$less(a, b)) < width::<Self, S>()
            }
            #[inline(always)]
            fn largest<S: Simd>(simd: S, a: S::$vector) -> f64 {
                f64::from(simd.$largest(a))
            }
            #[inline(always)]
            fn deinterleave<S: Simd>(simd: S, groups: [S::$vector; 4]) -> [S::$vector; 4] {
                simd.$deinterleave(groups)
            }
            #[inline(always)]
            fn interleave<S: Simd>(simd: S, lanes: [S::$vector; 4]) -> [S::$vector; 4] {
                simd.$interleave(lanes)
            }
        }
    };
}

real!(
    f32,
    1e-13,
    f32s,
    splat_f32s,
    add_f32s,
    sub_f32s,
    mul_f32s,
    mul_add_e_f32s,
    neg_f32s,
    div_f32s,
    min_f32s,
    max_f32s,
    sqrt_f32s,
    less_than_f32s,
    select_f32s,
    first_true_m32s,
    reduce_max_f32s,
    deinterleave_shfl_f32s,
    interleave_shfl_f32s
);
real!(
    f64,
    1e-60,
    f64s,
    splat_f64s,
    add_f64s,
    sub_f64s,
    mul_f64s,
    mul_add_e_f64s,
    neg_f64s,
    div_f64s,
    min_f64s,
    max_f64s,
    sqrt_f64s,
    less_than_f64s,
    select_f64s,
    first_true_m64s,
    reduce_max_f64s,
    deinterleave_shfl_f64s,
    interleave_shfl_f64s
);
