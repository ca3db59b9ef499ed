//! The arguments of a sweep: slices of equal length, alone or in a tuple, each `&` or `&mut`.
//!
//! Threads share pointers to the slices and take the elements one by one. Splitting the slices, as zipped parallel
//! iterators do, ends in the same loop, but each use takes twice as long to compile.

use std::marker::PhantomData;

/// `&[T]`, `&mut [T]`, or a tuple of these.
pub trait Columns {
    /// The elements at one index.
    type Item;
    /// Pointers to the elements.
    type Pointers: Copy + Send + Sync;

    /// The length of the slices.
    fn length(&self) -> usize;

    /// The pointers to the elements, which all threads share.
    fn pointers(self) -> Self::Pointers;

    /// The elements at an index.
    ///
    /// # Safety
    /// The index is below the length and is passed only once.
    unsafe fn at(pointers: Self::Pointers, index: usize) -> Self::Item;
}

impl<'a, T: Sync> Columns for &'a [T] {
    type Item = &'a T;
    type Pointers = &'a [T];

    #[inline(always)]
    fn length(&self) -> usize {
        self.len()
    }

    #[inline(always)]
    fn pointers(self) -> Self::Pointers {
        self
    }

    #[inline(always)]
    unsafe fn at(pointers: Self::Pointers, index: usize) -> Self::Item {
        // SAFETY: the index is below the length.
        unsafe { pointers.get_unchecked(index) }
    }
}

/// A pointer to the first element of a slice that threads write.
pub struct FirstElement<'a, T>(*mut T, PhantomData<&'a mut [T]>);

impl<T> Clone for FirstElement<'_, T> {
    #[inline(always)]
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for FirstElement<'_, T> {}

// SAFETY: it represents a `&mut [T]`, each of whose elements goes to one thread.
unsafe impl<T: Send> Send for FirstElement<'_, T> {}
// SAFETY: as above.
unsafe impl<T: Send> Sync for FirstElement<'_, T> {}

impl<'a, T: Send> Columns for &'a mut [T] {
    type Item = &'a mut T;
    type Pointers = FirstElement<'a, T>;

    #[inline(always)]
    fn length(&self) -> usize {
        self.len()
    }

    #[inline(always)]
    fn pointers(self) -> Self::Pointers {
        FirstElement(self.as_mut_ptr(), PhantomData)
    }

    #[inline(always)]
    unsafe fn at(pointers: Self::Pointers, index: usize) -> Self::Item {
        // SAFETY: the index is below the length, and no other reference to this element is made.
        unsafe { &mut *pointers.0.add(index) }
    }
}

macro_rules! tuple_of_columns {
    ($first:ident $($column:ident)*) => {
        #[allow(non_snake_case, reason = "a type and the value of it share a name")]
        impl<$first: Columns, $($column: Columns),*> Columns for ($first, $($column),*) {
            type Item = ($first::Item, $($column::Item),*);
            type Pointers = ($first::Pointers, $($column::Pointers),*);

            #[inline(always)]
            fn length(&self) -> usize {
                let ($first, $($column),*) = self;
                let length = $first.length();
                $(assert_eq!($column.length(), length, "columns of different lengths");)*
                length
            }

            #[inline(always)]
            fn pointers(self) -> Self::Pointers {
                let ($first, $($column),*) = self;
                ($first.pointers(), $($column.pointers()),*)
            }

            #[inline(always)]
            unsafe fn at(pointers: Self::Pointers, index: usize) -> Self::Item {
                let ($first, $($column),*) = pointers;
                // SAFETY: guaranteed by the caller, and the lengths are equal.
                unsafe { ($first::at($first, index), $($column::at($column, index)),*) }
            }
        }
    };
}
tuple_of_columns!(A B);
tuple_of_columns!(A B C);
tuple_of_columns!(A B C D);
tuple_of_columns!(A B C D E F);
