export default function Page() { return <h1>execution</h1>; }
