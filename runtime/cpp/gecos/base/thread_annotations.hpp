#pragma once

/// Annotations that say which mutex guards a member, and which mutex a function needs. Clang checks
/// them with -Wthread-safety (https://clang.llvm.org/docs/ThreadSafetyAnalysis.html); for other
/// compilers they are empty.
///
/// Clang checks a lambda as a separate function. Therefore a lambda that uses guarded members must
/// begin with `mutex.assert_held();`, or must have the annotation after its parameters.
#if defined(__clang__)
#define GECOS_THREAD_ANNOTATION(x) __attribute__((x))
#else
#define GECOS_THREAD_ANNOTATION(x)
#endif

/// Marks a class that is a mutex, or that represents the right to access something.
#define GECOS_CAPABILITY(name) GECOS_THREAD_ANNOTATION(capability(name))
/// Marks a class that holds a mutex from its constructor to its destructor.
#define GECOS_SCOPED_CAPABILITY GECOS_THREAD_ANNOTATION(scoped_lockable)

/// Marks a member that may be read and written only while `mutex` is held.
#define GECOS_GUARDED_BY(mutex) GECOS_THREAD_ANNOTATION(guarded_by(mutex))
/// Marks a pointer whose target may be accessed only while `mutex` is held.
#define GECOS_POINTER_GUARDED_BY(mutex) GECOS_THREAD_ANNOTATION(pt_guarded_by(mutex))

/// REQUIRES marks a function whose caller must hold the given mutexes. EXCLUDES marks a function
/// whose caller must not hold them.
#define GECOS_REQUIRES(...) GECOS_THREAD_ANNOTATION(requires_capability(__VA_ARGS__))
#define GECOS_EXCLUDES(...) GECOS_THREAD_ANNOTATION(locks_excluded(__VA_ARGS__))

/// Annotations for the methods of the classes that are mutexes or locks.
#define GECOS_ACQUIRE(...) GECOS_THREAD_ANNOTATION(acquire_capability(__VA_ARGS__))
#define GECOS_TRY_ACQUIRE(...) GECOS_THREAD_ANNOTATION(try_acquire_capability(__VA_ARGS__))
#define GECOS_RELEASE(...) GECOS_THREAD_ANNOTATION(release_capability(__VA_ARGS__))
#define GECOS_ASSERT_HELD(...) GECOS_THREAD_ANNOTATION(assert_capability(__VA_ARGS__))

/// Marks a function whose locking the analysis cannot follow. A comment at the function must say
/// why its locking is correct.
#define GECOS_NOT_ANALYSED GECOS_THREAD_ANNOTATION(no_thread_safety_analysis)
