#pragma once

/// Annotations that clang's -Wthread-safety checks: which mutex guards a member, which mutex a
/// function needs. Empty for other compilers. https://clang.llvm.org/docs/ThreadSafetyAnalysis.html
///
/// A lambda is checked as a function of its own: a lambda that uses guarded members must begin with
/// `mutex.assert_held();`, or have the attribute after its parameters.
#if defined(__clang__)
#define GECOS_THREAD_ANNOTATION(x) __attribute__((x))
#else
#define GECOS_THREAD_ANNOTATION(x)
#endif

/// A class that is a mutex, or represents the right to access something.
#define GECOS_CAPABILITY(name) GECOS_THREAD_ANNOTATION(capability(name))
/// A class that holds a mutex from its constructor to its destructor.
#define GECOS_SCOPED_CAPABILITY GECOS_THREAD_ANNOTATION(scoped_lockable)

/// A member that may be read and written only while `mutex` is held.
#define GECOS_GUARDED_BY(mutex) GECOS_THREAD_ANNOTATION(guarded_by(mutex))
/// A pointer whose target may be accessed only while `mutex` is held.
#define GECOS_POINTER_GUARDED_BY(mutex) GECOS_THREAD_ANNOTATION(pt_guarded_by(mutex))

/// A function whose caller must hold these mutexes; a function whose caller must not hold them.
#define GECOS_REQUIRES(...) GECOS_THREAD_ANNOTATION(requires_capability(__VA_ARGS__))
#define GECOS_EXCLUDES(...) GECOS_THREAD_ANNOTATION(locks_excluded(__VA_ARGS__))

/// For the methods of mutexes and locks themselves.
#define GECOS_ACQUIRE(...) GECOS_THREAD_ANNOTATION(acquire_capability(__VA_ARGS__))
#define GECOS_TRY_ACQUIRE(...) GECOS_THREAD_ANNOTATION(try_acquire_capability(__VA_ARGS__))
#define GECOS_RELEASE(...) GECOS_THREAD_ANNOTATION(release_capability(__VA_ARGS__))
#define GECOS_ASSERT_HELD(...) GECOS_THREAD_ANNOTATION(assert_capability(__VA_ARGS__))

/// A function whose locking the analysis cannot follow; a comment must say why its locking is
/// correct.
#define GECOS_NOT_ANALYSED GECOS_THREAD_ANNOTATION(no_thread_safety_analysis)
